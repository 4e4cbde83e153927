#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// One surfel: an oriented disc, in the world frame.
struct Surfel {
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // unit length, towards the observer
  Rgb8 color;
  float radius_m = 0;
  float confidence = 0;         // sum of the weights of its observations
  std::int32_t first_seen = 0;  // frame index
  std::int32_t last_seen = 0;   // frame index
  bool at_edge = false;         // no observation yet but at depth edges
};

// A measured point that is to be merged with a surfel.
struct SurfelObservation {
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // unit length
  Rgb8 color;
  float radius_m = 0;
  float weight = 1;      // a
  bool at_edge = false;  // at a depth edge, with the normal of a neighbour
};

}  // namespace surfit
