#pragma once

#include <vector>

#include "mapping/measured_points.h"
#include "mapping/point_average.h"
#include "mapping/posed_camera.h"
#include "mapping/surfel_choice.h"
#include "surfit/frame/rgbd_frame.h"

namespace surfit {

// What the points of a frame have seen of the surfels they chose.
class Sightings {
 public:
  struct Counts {
    int points = 0;   // that have chosen a surfel
    int surfels = 0;  // that have been chosen
    Counts& operator+=(const Counts& other) {
      points += other.points;
      surfels += other.surfels;
      return *this;
    }
  };

  // Points with a larger radius than this times a surfel's do not tell of its shape.
  explicit Sightings(float max_radius_ratio) : max_radius_ratio_(max_radius_ratio) {}

  // Averages the points of each candidate that was chosen, and tells it so: what it is given stays
  // until the next frame. In the order of the image, as gathering them surfel by surfel would wait
  // for memory half of the time.
  Counts Gather(const RgbdFrame& frame, const std::vector<MeasuredPoint>& points,
                const Image<float>& weights, const PosedCamera& camera, const SurfelChoice& choice);

 private:
  const float max_radius_ratio_;
  std::vector<std::vector<SurfelObservation>> in_band_;
};

}  // namespace surfit
