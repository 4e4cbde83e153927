#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/repeated_warning.h"
#include "surfit/core/image.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Facts about the processed frames of a run that its last stages need. Frames are named by index.
class FrameFacts {
 public:
  // Also warns about frames that repeat the depth of the frame before.
  void Add(const RgbdFrame& frame, const FrameReport& report);

  // Warning that no frame has enough normals to begin the map. std::nullopt if any frame has a
  // pose, and without frames. `min_inliers`: IcpOptions::min_inliers.
  std::optional<std::string> DepthWarning(int min_inliers) const;

  const std::set<int>& lost() const { return lost_; }
  // Held-out and duplicate frames: not in the final map.
  const std::set<int>& left_out() const { return left_out_; }
  // FrameReport::moving of the frames with moving objects.
  const std::map<int, Image<std::uint8_t>>& moving() const { return moving_; }

 private:
  std::set<int> lost_, left_out_;
  std::map<int, Image<std::uint8_t>> moving_;
  RepeatedWarning repeated_{"frames that repeat the depth of the frame before"};
  bool has_pose_ = false;                                          // of any frame
  int width_ = 0, height_ = 0;                                     // of the last frame
  std::size_t pixels_without_pose_ = 0, depths_without_pose_ = 0;  // of frames before a pose
};

}  // namespace surfit
