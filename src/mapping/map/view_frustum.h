#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mapping/rendering/posed_camera.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Viewing volume of a camera with an image margin: five planes in the world frame. There is no far
// plane. The near plane is at kMinDepth.
class ViewFrustum {
 public:
  ViewFrustum(const PosedCamera& camera, float margin_px);

  // False only if no surfel in these bounds is visible. The bounds must not be empty.
  bool MaySee(const SurfelBounds& bounds) const {
    const Eigen::Map<const Eigen::Vector3f> low(bounds.low), high(bounds.high);
    const Eigen::Vector3f middle = 0.5f * (high + low);
    const Eigen::Vector3f half = 0.5f * (high - low) + RoundingAt(middle);
    for (const Plane& plane : planes_) {
      // Tests the corner that is farthest inside.
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

  // Maximum rounding error of a position in the camera frame.
  Eigen::Vector3f RoundingAt(const Eigen::Vector3f& position) const {
    return Eigen::Vector3f::Constant(2e-6f * (position.lpNorm<1>() + camera_position_norm_));
  }

  std::array<Plane, 5> planes_;
  float camera_position_norm_;
};

// Indices of the cells that may have visible surfels, ascending.
std::vector<std::int32_t> VisibleCells(const SurfelMap& map, const ViewFrustum& frustum);

}  // namespace surfit
