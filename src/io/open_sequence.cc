#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "io/depth_scale_check.h"
#include "io/detect_format.h"
#include "io/folder.h"
#include "io/image_sequence.h"
#include "io/sequence_camera.h"
#include "io/sequence_files.h"
#include "surfit/core/error.h"
#include "surfit/geometry/mirror.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

SequenceFiles ListSequence(const std::string& format, const std::string& folder,
                           double frames_per_second) {
  if (format == "seven_scenes") return ListSevenScenesSequence(folder, frames_per_second);
  if (format == "redwood") return ListRedwoodSequence(folder, frames_per_second);
  if (format == "icl_nuim") return ListIclNuimSequence(folder);
  return ListTumSequence(folder);
}

std::vector<IndexedFrame> SelectFrames(const std::vector<FrameFiles>& all,
                                       const SequenceOptions& options) {
  const int count = static_cast<int>(all.size());
  if (count == 0) throw InputError(options.path + " lists no frames");
  if (options.first >= count)
    throw InputError(Concat("first is ", options.first, ", must be below ", count,
                            ", the number of frames of ", options.path));
  const int last = options.last == -1 ? count - 1 : std::min(options.last, count - 1);
  std::vector<IndexedFrame> frames;
  for (int i = options.first; i <= last; i += options.stride) frames.push_back({i, all[i]});
  return frames;
}

struct FirstImages {
  FrameFiles files;
  FrameImages images;
};

// The first frame whose files can be read; throws the first one's error if none can.
FirstImages ReadFirstImages(const std::vector<IndexedFrame>& frames) {
  std::string first_error;
  for (const IndexedFrame& frame : frames) {
    try {
      return {frame.files, ReadFrameImages(frame.files)};
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  throw InputError("no frame can be read: " + first_error);
}

template <typename T>
void TakeSizeIfUnknown(const Image<T>& image, PinholeCamera* camera) {
  if (camera->width != 0) return;
  camera->width = image.width();
  camera->height = image.height();
}

void CompleteCamera(const FirstImages& first, RgbdCamera* camera) {
  std::visit([&](const auto& depth) { TakeSizeIfUnknown(depth, &camera->depth); },
             first.images.depth);
  if (!camera->color_is_registered) {
    if (first.images.color.empty()) camera->color_is_registered = true;
    TakeSizeIfUnknown(first.images.color, &camera->color);
  }
  RequireSizeOf(*camera, first.images, first.files);
}

void Mirror(Trajectory* trajectory) {
  for (StampedPose& pose : *trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
}

}  // namespace

std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options) {
  options.Validate();
  if (!IsFolder(options.path)) throw InputError(options.path + " is no folder");
  SequenceInfo info;
  info.format = options.format == "auto" ? DetectFormat(options.path) : options.format;
  info.camera = ResolveCamera(options, info.format, &info.warnings);
  SequenceFiles files = ListSequence(info.format, options.path, info.camera.frames_per_second);
  std::vector<IndexedFrame> frames = SelectFrames(files.frames, options);
  const FirstImages first = ReadFirstImages(frames);
  CompleteCamera(first, &info.camera);
  if (auto warning = DepthScaleWarning(first.images.depth, info.camera.depth_units_per_metre,
                                       first.files.depth_path))
    info.warnings.push_back(*warning);

  info.mirrored = info.camera.depth.fy < 0;
  info.ground_truth = std::move(files.ground_truth);
  if (info.mirrored) Mirror(&info.ground_truth);
  FramePreparer preparer(info.mirrored ? Mirrored(info.camera) : info.camera, options.prepare);
  info.pinhole = preparer.pinhole();
  info.frame_count = static_cast<int>(frames.size());
  for (const std::string& warning : info.warnings) LOG(WARNING) << warning;
  return std::make_unique<ImageSequence>(std::move(info), std::move(frames), std::move(preparer));
}

}  // namespace surfit
