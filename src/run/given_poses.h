#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Compares given poses with depth images. Projects the depth of a frame into a later frame, by the
// given poses and by other conventions of pose files. Conventions: inverse poses, quaternions with
// w first, camera axes of OpenGL or ROS, and translations in mm. Not thread-safe.
class GivenPoseCheck {
 public:
  explicit GivenPoseCheck(const PinholeCamera& camera);

  // Adds a frame with its given pose. Add frames in order.
  void Add(const RgbdFrame& frame, const Rigid3d& world_from_camera);

  // Warning if the depth images contradict the given poses, with the convention that agrees best.
  // std::nullopt if they agree, and with fewer than three comparisons.
  std::optional<std::string> Warning() const;

 private:
  struct View {
    Image<float> depth_m;  // subsampled
    Rigid3d world_from_camera;
  };

  // Depth that agrees under one hypothesis, over all comparisons.
  struct Agreement {
    double sum = 0;  // of the ratios of depth that agrees
    int better = 0;  // comparisons with more agreement than the given poses
  };

  void Compare(const View& from, const View& to);
  void Count(double ratio, Agreement* agreement);
  bool IsBetter(const Agreement& agreement) const;

  PinholeCamera camera_;  // of subsampled images
  int step_;              // of subsampling
  int count_ = 0, comparisons_ = 0;
  std::deque<View> views_;             // of the last frames
  std::vector<Agreement> agreements_;  // one per convention; first: given convention
  Agreement without_motion_;           // of a camera that does not move
  double given_ = 0;                   // ratio of the given poses in the present comparison
};

}  // namespace surfit
