#pragma once

#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Moves each surfel along its normal to the average of its neighbours on the same surface, and
// averages the normals. This reduces noise on surfaces that are covered by several surfels.
// Neighbour j has the distance d_j and a plane with normal n_j. The distance between surfel i and
// this plane along n_i is
//   h_j = n_j . (p_j - p_i) / n_j . n_i.
// Surfel i moves by the average of h_j with the weights
//   c_j exp(-2 d_j^2 / R^2 - h_j^2 / s^2) max(0, 1 - (1 - n_i . n_j) / 0.1),
//   R = min(3 r_i, 3 cm),   s = 1 mm + sigma_i / sqrt(c_i) + sigma_j / sqrt(c_j).
// In the formula of s, confidences below 1 are replaced by 1. The radius r of a surfel determines
// its depth z = r f / sqrt(2), at which the sensor has the noise sigma. Steps and creases above the
// noise remain.
//
// Neighbours at depth edges are ignored, because their normals come from other pixels. The
// algorithm makes two passes. The result is bitwise identical for any number of threads. Surfels
// without neighbours stay. `sensor`: sensor of the fused frames.
void SmoothMap(const DepthSensor& sensor, SurfelMap* map);

}  // namespace surfit
