#include "io/sequence_info.h"

#include <glog/logging.h>

#include "io/depth_scale_check.h"
#include "io/image_sequence.h"
#include "surfit/geometry/mirror.h"

namespace surfit {
namespace {

template <typename T>
void TakeSizeIfUnknown(const Image<T>& image, PinholeCamera* camera) {
  if (camera->width != 0) return;
  camera->width = image.width();
  camera->height = image.height();
}

void CompleteCamera(const FrameImages& first, RgbdCamera* camera) {
  std::visit([&](const auto& depth) { TakeSizeIfUnknown(depth, &camera->depth); }, first.depth);
  if (!camera->color_is_registered) {
    if (first.color.empty()) camera->color_is_registered = true;
    TakeSizeIfUnknown(first.color, &camera->color);
  }
  RequireSizeOf(*camera, first);
}

void Mirror(Trajectory* trajectory) {
  for (StampedPose& pose : *trajectory) pose.world_from_camera = Mirrored(pose.world_from_camera);
}

}  // namespace

FramePreparer CompleteInfo(const FrameImages& first, const PrepareOptions& options,
                           SequenceInfo* info) {
  CompleteCamera(first, &info->camera);
  if (auto warning =
          DepthScaleWarning(first.depth, info->camera.depth_units_per_metre, first.depth_name))
    info->warnings.push_back(*warning);
  info->mirrored = info->camera.depth.fy < 0;
  if (info->mirrored) Mirror(&info->ground_truth);
  FramePreparer preparer(info->mirrored ? Mirrored(info->camera) : info->camera, options);
  info->pinhole = preparer.pinhole();
  for (const std::string& warning : info->warnings) LOG(WARNING) << warning;
  return preparer;
}

}  // namespace surfit
