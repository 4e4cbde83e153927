#pragma once

#include <array>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Source points at one pose, and where they land in the target's image I.
struct IntensityPairs {
  RawVector<float> px, py, pz;        // p' = R p + t, metres
  RawVector<float> source;            // the point's own intensity J
  RawVector<float> target;            // I at the pixel (u, v) of p'
  RawVector<float> slope_u, slope_v;  // dI/du, dI/dv there, per px
  int size = 0;

  static constexpr int kArrays = 7;
  std::array<RawVector<float>*, kArrays> Arrays() {
    return {&px, &py, &pz, &source, &target, &slope_u, &slope_v};
  }
  void SetCapacity(int capacity) {
    for (auto* array : Arrays()) array->resize(capacity);
  }
};

// Source points with their intensities.
struct TexturedPoints {
  std::vector<float> x, y, z, intensity;
};

// By how much the exposures of two images differ at most, either way.
inline constexpr double kMaxGain = 1.5;

// The source's intensities as the target would see them: gain * J + offset.
struct Exposure {
  float gain = 1;
  float offset = 0;

  // r_I of a pair.
  float Residual(const IntensityPairs& pairs, int i) const {
    return pairs.target[i] - (gain * pairs.source[i] + offset);
  }
};

// What intensities say of a pose, r_I = I(pi(R p + t)) - (gain J(p) + offset), over the source
// points where J changes by a sigma per px or more: elsewhere r_I is noise, whatever the pose. What
// the target sees at another depth is hidden there, and has no say.
class PhotometricTerm {
 public:
  // Keeps references: both levels must outlive this object, and have intensities. The exposure is
  // estimated at the start and kept, so that all steps minimise the same. Points are hidden if
  // their depth differs by more than max_distance_m; 0 = off.
  PhotometricTerm(const FrameLevel& source, const FrameLevel& target, double max_distance_m,
                  const ErrorModel& error_model, const Rigid3d& start);

  const PinholeCamera& camera() const { return target_.camera; }
  const Exposure& exposure() const { return exposure_; }
  double information() const { return information_; }     // W / sigma^2
  const RobustKernel& kernel() const { return kernel_; }  // of r_I^2 * information

  // The points come in blocks of a fixed order. Blocks may be asked for at the same time.
  int block_count() const { return static_cast<int>(blocks_.size()); }
  // Replaces `pairs` by those of a block; their arrays may be longer than their size.
  void Find(int block, const Rigid3d& target_from_source, IntensityPairs* pairs) const;
  // The pairs of all blocks; arrays of their size.
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
