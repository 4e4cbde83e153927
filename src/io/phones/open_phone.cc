#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

// A camera file or a preset takes precedence over the camera of the recording.
bool HasCameraOption(const SequenceOptions& options, const std::string& format) {
  return !options.camera.empty() || !CameraFile(options, format).empty();
}

double FramesPerSecond(const SequenceOptions& options, const std::string& format) {
  if (options.frames_per_second) return *options.frames_per_second;
  const std::string yaml = CameraFile(options, format);
  if (!yaml.empty()) return ReadCameraYaml(yaml).frames_per_second;
  return options.camera.empty() ? RgbdCamera().frames_per_second
                                : CameraPreset(options.camera).frames_per_second;
}

}  // namespace

bool IsPhone(const std::string& format) {
  return format == "stray_scanner" || format == "arkit_scenes" || format == "polycam" ||
         format == "record3d" || format == "nerfstudio";
}

OpenedRecording OpenPhone(const SequenceOptions& options, const std::string& format) {
  const std::string& path = options.path;
  const bool confidence = options.confidence;
  if (format == "arkit_scenes") return OpenPhoneFiles(ListArkitScenes(path, confidence));
  if (format == "polycam") return OpenPhoneFiles(ListPolycam(path, confidence));
  if (format == "record3d") return OpenPhoneFiles(ListRecord3d(path, confidence));
  if (format == "nerfstudio") {
    return OpenPhoneFiles(ListNerfstudio(path, FramesPerSecond(options, format),
                                         HasCameraOption(options, format), confidence));
  }
  return OpenPhoneFiles(ListStrayScanner(path, confidence));
}

void AddPhoneConfidence(const std::string& folder, PhoneFiles* files) {
  if (!IsFolder(folder)) return;
  std::vector<FrameFiles> listed;
  listed.reserve(files->frames.size());
  for (const PhoneFrame& frame : files->frames) listed.push_back(frame.files);
  AddNamedConfidence(
      folder, /*has_clock=*/false, [](const std::string& error) { throw InputError(error); },
      &listed);
  SetConfidenceRange(&listed, &files->warnings);
  for (std::size_t i = 0; i < listed.size(); ++i) files->frames[i].files = listed[i];
}

}  // namespace surfit
