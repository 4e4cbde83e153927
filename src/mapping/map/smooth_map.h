#pragma once

#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Moves each surfel along its normal to where those beside it, of the same surface, have it, and
// takes the mean of their normals: of a surface that several surfels show, each one alone has more
// noise than all together. A neighbour j, at the distance d_j and with the normal n_j, has surfel i
// on its own plane, so that i moves by
//   h_j = n_j . (p_j - p_i) / n_j . n_i      along n_i,
// on average by the weights
//   c_j exp(-2 d_j^2 / R^2 - h_j^2 / s^2) max(0, 1 - (1 - n_i . n_j) / 0.1),
//   R = min(3 r_i, 3 cm),   s = 1 mm + sigma_i / sqrt(c_i) + sigma_j / sqrt(c_j),
// with confidences c, the surfel's radius r and the noise sigma of one measurement by the sensor
// from where a pixel is as large as the surfel. A confidence below 1 counts as 1 there. So steps
// and creases that are more than noise stay. Surfels at depth edges, whose normals are not their
// own, count for nothing. It is done twice. The same map gives the same one bit for bit at any
// number of threads.
void SmoothMap(const DepthSensor& sensor, SurfelMap* map);

}  // namespace surfit
