#pragma once

#include <array>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Source points at one pose, with their projections into the target image I. The first `size`
// values of each array are valid.
struct IntensityPairs {
  RawVector<float> px, py, pz;        // p' = R p + t in the target frame, m
  RawVector<float> source;            // intensity J of the source point
  RawVector<float> target;            // I at the pixel (u, v) of p'
  RawVector<float> slope_u, slope_v;  // dI/du and dI/dv at (u, v), per px
  int size = 0;

  static constexpr int kArrays = 7;
  std::array<RawVector<float>*, kArrays> Arrays() {
    return {&px, &py, &pz, &source, &target, &slope_u, &slope_v};
  }
  void SetCapacity(int capacity) {
    for (auto* array : Arrays()) array->resize(capacity);
  }
};

// Source points with their intensities. Positions in the camera frame, m.
struct TexturedPoints {
  std::vector<float> x, y, z, intensity;
};

inline constexpr double kMaxGain = 1.5;

// Exposure correction from source to target intensities: gain * J + offset.
struct Exposure {
  float gain = 1;
  float offset = 0;

  // Intensity difference of pair i, not divided by sigma.
  float Residual(const IntensityPairs& pairs, int i) const {
    return pairs.target[i] - (gain * pairs.source[i] + offset);
  }
};

// Photometric residuals r_I = I(pi(R p + t)) - (gain J(p) + offset). Uses source points with an
// intensity gradient of at least one sigma per px, because residuals of other points are noise.
// Ignores points that are occluded in the target.
class PhotometricTerm {
 public:
  // Both levels must have intensities. Keeps a reference to the target, which must outlive this
  // object. Estimates the exposure at `start` and keeps it, so that all steps minimise the same
  // cost. The term is empty (no blocks) if fewer than 100 points are available for this estimate.
  // Aborts if an image width differs from that of its level. Points whose depth differs from the
  // target depth by more than max_distance_m are occluded; 0: no limit.
  PhotometricTerm(const FrameLevel& source, const FrameLevel& target, double max_distance_m,
                  const ErrorModel& error_model, const Rigid3d& start);

  const PinholeCamera& camera() const { return target_.camera; }
  const Exposure& exposure() const { return exposure_; }
  double information() const { return information_; }     // W / sigma^2
  const RobustKernel& kernel() const { return kernel_; }  // of r_I^2 * information

  // Blocks have a fixed order. Find() is thread-safe.
  int block_count() const { return static_cast<int>(blocks_.size()); }
  // Replaces `pairs` by the pairs of a block. The arrays can be longer than pairs->size.
  void Find(int block, const Rigid3d& target_from_source, IntensityPairs* pairs) const;
  // Pairs of all blocks. The arrays have exactly the size of the result.
  IntensityPairs Collect(const Rigid3d& target_from_source) const;

 private:
  const FrameLevel& target_;
  double max_distance_m_;
  double information_;
  RobustKernel kernel_;
  std::vector<TexturedPoints> blocks_;
  Exposure exposure_;
};

}  // namespace surfit
