#pragma once

#include <algorithm>

#include "mapping/measured_points.h"
#include "mapping/posed_camera.h"
#include "surfit/mapping/surfel.h"

namespace surfit {

// The average of the points that have chosen a surfel, as one observation of it.
class PointAverage {
 public:
  // Points with a larger radius do not tell of the surfel's shape, nor do those at depth edges.
  explicit PointAverage(float max_radius_m) : max_radius_m_(max_radius_m) {}

  void Add(const MeasuredPoint& point, float weight, Rgb8 color) {
    ++count_;
    weight_ += weight;
    color_ += weight * Eigen::Vector3f(color.r, color.g, color.b);
    at_edge_ &= point.at_edge;
    if (point.at_edge || !(point.radius_m < max_radius_m_)) return;
    shape_weight_ += weight;
    position_ += weight * point.position();
    normal_ += weight * point.normal();
    radius_m_ = std::min(radius_m_, point.radius_m);
  }

  int count() const { return count_; }

  // There must be a point.
  SurfelObservation Observation(const PosedCamera& camera) const {
    SurfelObservation seen;
    seen.weight = weight_;
    seen.color = color_ / weight_;
    seen.at_edge = at_edge_;
    seen.shape_weight = shape_weight_;
    if (shape_weight_ == 0.f) return seen;
    const float scale = 1.f / shape_weight_;
    seen.position_in_world = camera.PointInWorld(scale * position_);
    seen.normal_in_world = camera.world_rotation * (scale * normal_);
    seen.radius_m = radius_m_;
    return seen;
  }

 private:
  const float max_radius_m_;
  int count_ = 0;
  float weight_ = 0, shape_weight_ = 0, radius_m_ = max_radius_m_;
  Eigen::Vector3f position_ = Eigen::Vector3f::Zero(), normal_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f color_ = Eigen::Vector3f::Zero();
  bool at_edge_ = true;
};

}  // namespace surfit
