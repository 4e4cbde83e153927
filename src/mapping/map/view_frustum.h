#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mapping/rendering/posed_camera.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// The part of space that a camera sees, with a margin around the image: five planes, in the world.
class ViewFrustum {
 public:
  ViewFrustum(const PosedCamera& camera, float margin_px);

  // False only if none of the surfels is seen.
  bool MaySee(const SurfelBounds& bounds) const {
    const Eigen::Map<const Eigen::Vector3f> low(bounds.low), high(bounds.high);
    const Eigen::Vector3f middle = 0.5f * (high + low);
    const Eigen::Vector3f half = 0.5f * (high - low) + RoundingAt(middle);
    for (const Plane& plane : planes_) {
      // The corner that is farthest inside; so that NaN and infinity count as seen.
      if (plane.inwards.dot(middle) + plane.inwards.cwiseAbs().dot(half) < plane.offset) {
        return false;
      }
    }
    return true;
  }

 private:
  struct Plane {  // inside: inwards . x >= offset
    Eigen::Vector3f inwards;
    float offset;
  };

  // Bounds what single precision makes of a position on its way into the camera's frame.
  Eigen::Vector3f RoundingAt(const Eigen::Vector3f& position) const {
    return Eigen::Vector3f::Constant(2e-6f * (position.lpNorm<1>() + camera_position_norm_));
  }

  std::array<Plane, 5> planes_;
  float camera_position_norm_;
};

// The cells that have surfels which the camera may see, in their order.
std::vector<std::int32_t> VisibleCells(const SurfelMap& map, const ViewFrustum& frustum);

}  // namespace surfit
