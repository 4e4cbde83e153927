#pragma once

#include <cstring>
#include <vector>

#include "mapping/fusion/measured_points.h"
#include "mapping/map/surfel_assignment.h"
#include "mapping/rendering/frame_colors.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Averages the points of a surfel to one observation. The position and normal are weighted means,
// the radius is the smallest. The observation is at a depth edge if all points are.
class PointAverage {
 public:
  // Coarser points and points at depth edges do not affect the shape.
  explicit PointAverage(float max_radius_m)
      : max_radius_m_(max_radius_m), radius_m_(max_radius_m) {}

  // `weight`: from PointWeights(), must be positive.
  void Add(const MeasuredPoint& point, float weight) {
    const bool has_shape = !point.at_edge & (point.radius_m < max_radius_m_);
    const float shape_weight = has_shape ? weight : 0.f;
    weight_ += weight;
    shape_weight_ += shape_weight;
    Four first, last;
    std::memcpy(&first, &point.patch.x, sizeof(first));
    std::memcpy(&last, &point.patch.z, sizeof(last));
    first_ += shape_weight * first;
    last_ += shape_weight * last;
    const float radius_m = has_shape ? point.radius_m : max_radius_m_;
    radius_m_ = radius_m < radius_m_ ? radius_m : radius_m_;
    at_edge_ &= point.at_edge;
  }

  // Requires at least one point. Colours are added later. Position and normal are in the world
  // frame, and unset if `shape_weight` is 0. The normal has no unit length.
  SurfelObservation Observation(const PosedCamera& camera) const {
    SurfelObservation seen;
    seen.weight = weight_;
    seen.color_weight = 0;
    seen.at_edge = at_edge_;
    seen.shape_weight = shape_weight_;
    if (shape_weight_ == 0.f) return seen;
    const float scale = 1.f / shape_weight_;
    const Eigen::Vector3f position(first_[0], first_[1], first_[2]);
    const Eigen::Vector3f normal(last_[1], last_[2], last_[3]);
    seen.position_in_world = camera.PointInWorld(scale * position);
    seen.normal_in_world = camera.world_rotation * (scale * normal);
    seen.radius_m = radius_m_;
    return seen;
  }

 private:
  using Four __attribute__((vector_size(16))) = float;

  const float max_radius_m_;
  float radius_m_;
  float weight_ = 0, shape_weight_ = 0;
  Four first_ = {}, last_ = {};
  bool at_edge_ = true;
};

// Observations of the surfels of a frame. Not thread-safe: Gather() uses several threads itself.
class FrameObservations {
 public:
  // Number of assigned points, and of surfels that have points.
  struct Counts {
    int points = 0;
    int surfels = 0;
    Counts& operator+=(const Counts& other) {
      points += other.points;
      surfels += other.surfels;
      return *this;
    }
  };

  // Averages the points of each chosen candidate, and sets Candidate::seen, which is valid until
  // the next call. `points` and `weights` are per pixel. `choice`: after AssignAll(). Without
  // colour, all colour weights are 0.
  Counts Gather(const RgbdFrame& frame, const FrameColors& colors,
                const std::vector<MeasuredPoint>& points, const Image<float>& weights,
                const PosedCamera& camera, const SurfelAssignment& choice);

 private:
  std::vector<std::vector<SurfelObservation>> in_band_;
};

}  // namespace surfit
