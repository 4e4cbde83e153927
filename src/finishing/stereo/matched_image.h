#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "finishing/stereo/stereo_keyframe.h"
#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Inverse depths of the labels of CostVolume, 1/m, in equal steps.
struct LabelRange {
  float least = 0, step = 0;

  float InverseDepth(float label) const { return least + label * step; }
  float LabelOf(float inverse_depth) const { return (inverse_depth - least) / step; }
};

// Images of a keyframe for matching.
struct MatchedImage {
  explicit MatchedImage(const StereoKeyframe& keyframe);

  PinholeCamera camera;
  Rigid3d world_from_camera;
  Image<std::uint8_t> brightness;
  // 128 plus the difference of the brightness and its mean over 7 x 7 pixels.
  Image<std::uint8_t> detail;
  // Census transform (Zabih and Woodfill 1994) of windows with 9 columns and 7 rows. A pixel that
  // is darker than the centre by more than the image noise sets a bit. Bit 63 is set. 0: beside the
  // image border, or not visible.
  Image<std::uint64_t> census;
};

// The point at the inverse depth r on a ray of one image projects into another image. Its
// homogeneous pixel is rotation * ray + r * shift.
struct EpipolarLines {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f shift;
};

EpipolarLines LinesBetween(const MatchedImage& from, const MatchedImage& to);

}  // namespace surfit
