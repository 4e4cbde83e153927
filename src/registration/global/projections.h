#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Projections of source pixels into the target image, as a structure of arrays.
struct Projections {
  static constexpr int kCapacity = 64;

  int count = 0;
  alignas(32) float x[kCapacity] = {}, y[kCapacity] = {}, z[kCapacity] = {};  // p' = R p + t, m
  alignas(32) float u[kCapacity] = {}, v[kCapacity] = {};                     // position, px
  std::int32_t source_pixel[kCapacity] = {};  // index of the source pixel
  std::int32_t target_pixel[kCapacity] = {};  // index of the nearest target pixel

  Eigen::Vector3f Point(int k) const { return {x[k], y[k], z[k]}; }
};

// Projects the source pixels with depth into the target image.
class Projector {
 public:
  // Keeps the reference.
  Projector(const FrameLevel& source, const PinholeCamera& target,
            const Rigid3d& target_from_source);

  // Overwrites `projections` with those of row v. Starts at column `u`, in steps of `stride`. Skips
  // pixels without depth, points nearer than 0.05 m and projections outside the target image.
  // Returns the column at which the next call continues; at least the width after the last one.
  int Project(int u, int v, int stride, Projections* projections) const;

  const Eigen::Matrix3f& rotation() const { return rotation_; }  // R

 private:
  const FrameLevel& source_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;
  int width_, height_;  // of the target image
};

// Calls visit(projections) row by row for every stride-th source row and column, with at most
// Projections::kCapacity projections at a time.
template <typename Visit>
void ForEachProjections(const FrameLevel& source, const FrameLevel& target,
                        const Rigid3d& target_from_source, int stride, const Visit& visit) {
  const Projector projector(source, target.camera, target_from_source);
  Projections projections;
  for (int v = stride / 2; v < source.vertex.height(); v += stride) {
    for (int u = stride / 2; u < source.vertex.width();) {
      u = projector.Project(u, v, stride, &projections);
      visit(projections);
    }
  }
}

}  // namespace surfit
