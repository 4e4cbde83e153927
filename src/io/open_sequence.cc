#include <algorithm>
#include <utility>

#include "io/bags/bag_recording.h"
#include "io/folder.h"
#include "io/image_sequence.h"
#include "io/recording.h"
#include "io/sequence_camera.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

SequenceFiles ListSequence(const std::string& format, const std::string& folder,
                           double frames_per_second) {
  if (format == "seven_scenes") return ListSevenScenesSequence(folder, frames_per_second);
  if (format == "redwood") return ListRedwoodSequence(folder, frames_per_second);
  if (format == "replica") return ListReplicaSequence(folder, frames_per_second);
  if (format == "icl_nuim") return ListIclNuimSequence(folder);
  return ListTumSequence(folder);
}

OpenedRecording OpenRecording(const std::string& format, const std::string& path,
                              const RgbdCamera& camera) {
  if (format == "klg") return OpenKlg(path, {camera.depth.width, camera.depth.height});
  if (format == "sens") return OpenSens(path, camera.frames_per_second);
  SequenceFiles files = ListSequence(format, path, camera.frames_per_second);
  return {MakeFolderRecording(std::move(files.frames)),
          std::move(files.ground_truth),
          files.has_clock,
          {}};
}

OpenedRecording OfBag(std::unique_ptr<BagRecording> bag) {
  OpenedRecording opened;
  opened.has_clock = true;
  opened.warnings = bag->warnings();
  opened.frames = std::move(bag);
  return opened;
}

std::vector<int> SelectFrames(int count, const SequenceOptions& options) {
  if (count == 0) throw InputError(options.path + " lists no frames");
  if (options.first >= count)
    throw InputError(Concat("first is ", options.first, ", must be below ", count,
                            ", the number of frames of ", options.path));
  const int last = options.last == -1 ? count - 1 : std::min(options.last, count - 1);
  std::vector<int> indices;
  for (int i = options.first; i <= last; i += options.stride) indices.push_back(i);
  return indices;
}

// The first frame that can be read, and some that follow; throws the first one's error if none can.
std::vector<FrameImages> ReadFirstImages(const Recording& recording,
                                         const std::vector<int>& indices) {
  constexpr std::size_t kImages = 8, kApart = 15;
  std::vector<FrameImages> images;
  std::string first_error;
  for (std::size_t i = 0; i < indices.size() && images.size() < kImages;
       i += images.empty() ? 1 : kApart) {
    try {
      images.push_back(recording.Read(indices[i]));
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  if (images.empty()) throw InputError("no frame can be read: " + first_error);
  return images;
}

}  // namespace

std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options) {
  Validate(options);
  if (options.format == "watch")
    throw InputError("format is 'watch': only a live run (surfit_slam) waits for frames to come");
  if (!IsFolder(options.path) && !IsFile(options.path))
    throw InputError(options.path + " is neither a folder nor a file");
  SequenceInfo info;
  info.format = options.format == "auto" ? DetectFormat(options.path) : options.format;
  const bool is_file = IsFile(options.path);
  if (is_file ? !MayBeFile(info.format) : !MayBeFolder(info.format))
    throw InputError(Concat(options.path, " is a ", is_file ? "file" : "folder", ", which ",
                            info.format, " is not"));
  std::unique_ptr<BagRecording> bag;
  if (IsBag(info.format))
    bag = std::make_unique<BagRecording>(options, info.format, /*is_folder=*/!is_file);
  ResolveCamera(options, bag.get(), &info);

  OpenedRecording opened =
      bag ? OfBag(std::move(bag)) : OpenRecording(info.format, options.path, info.camera);
  if (!opened.has_clock) DropLatency(options, &info.camera);
  info.warnings.insert(info.warnings.end(), opened.warnings.begin(), opened.warnings.end());
  info.ground_truth = std::move(opened.ground_truth);
  std::vector<int> indices = SelectFrames(opened.frames->frame_count(), options);
  info.frame_count = static_cast<int>(indices.size());
  FramePreparer preparer =
      CompleteInfo(ReadFirstImages(*opened.frames, indices), options.prepare, &info);
  const InverseDepthField field = ReadDepthField(options, info.format);
  return CorrectedSource(std::make_unique<ImageSequence>(std::move(info), std::move(opened.frames),
                                                         std::move(indices), std::move(preparer)),
                         field);
}

}  // namespace surfit
