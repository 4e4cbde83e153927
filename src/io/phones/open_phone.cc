#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "surfit/core/error.h"

namespace surfit {

bool IsPhone(const std::string& format) {
  return format == "stray_scanner" || format == "arkit_scenes" || format == "polycam" ||
         format == "record3d";
}

OpenedRecording OpenPhone(const SequenceOptions& options, const std::string& format) {
  const std::string& path = options.path;
  const bool confidence = options.confidence;
  if (format == "arkit_scenes") return OpenPhoneFiles(ListArkitScenes(path, confidence));
  if (format == "polycam") return OpenPhoneFiles(ListPolycam(path, confidence));
  if (format == "record3d") return OpenPhoneFiles(ListRecord3d(path, confidence));
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
