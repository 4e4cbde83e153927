#include "run/frame_facts.h"

#include <algorithm>

#include "surfit/core/error.h"

namespace surfit {

void FrameFacts::Add(const RgbdFrame& frame, const FrameReport& report) {
  has_pose_ = has_pose_ || report.HasPose();
  if (!report.HasPose()) lost_.insert(report.index);
  if (report.confirmed) lost_.erase(report.confirmed->index);
  if (!has_pose_) {
    width_ = frame.depth_m.width();
    height_ = frame.depth_m.height();
    pixels_without_pose_ += frame.depth_m.size();
    depths_without_pose_ += std::count_if(frame.depth_m.begin(), frame.depth_m.end(),
                                          [](float depth_m) { return depth_m > 0; });
  }
  const bool is_duplicate = report.state == FrameState::kDuplicate;
  if (is_duplicate) {
    repeated_.Tell(Concat("frame ", report.index, " repeats the depth of the frame before: it is ",
                          "no measurement, and has the pose of that frame"));
  }
  if (report.is_held_out || is_duplicate) left_out_.insert(report.index);
  if (!report.moving.empty()) moving_[report.index] = report.moving;
}

std::optional<std::string> FrameFacts::DepthWarning(int min_inliers) const {
  if (has_pose_ || pixels_without_pose_ == 0) return std::nullopt;
  return Concat("no frame has ", min_inliers,
                " pixels with a surface normal, so no frame can begin the map. Images have ",
                width_, " x ", height_, " pixels, ",
                100 * depths_without_pose_ / pixels_without_pose_,
                " % of them have depth, and a normal needs depth in the rows and columns beside "
                "its pixel");
}

}  // namespace surfit
