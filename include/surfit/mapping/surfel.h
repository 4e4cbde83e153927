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

// What a frame has measured of a surfel: the average of its points there.
struct SurfelObservation {
  // Of those points that its shape can gain from.
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // not longer than one
  float radius_m = 0;                                           // the least
  float shape_weight = 1;                                       // the sum of their weights, or 0
  // Of all points.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  // sRGB, in 8-bit steps
  float color_weight = 1;                           // 0 without colours, else the weight
  float weight = 1;                                 // a, the sum
  bool at_edge = false;                             // at depth edges, with normals of neighbours
};

}  // namespace surfit
