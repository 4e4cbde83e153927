#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Upright world frame: z is up.
struct UprightWorld {
  Rigid3d upright_from_world;
  double sigma_rad = 0;                  // standard deviation of the direction of gravity
  int horizontal_planes = 0, walls = 0;  // used for the direction of gravity
  double horizontal_area_m2 = 0;
  double floor_area_m2 = 0;      // area of the plane at z = 0
  bool walls_give_axes = false;  // false: x is the projection of an axis of the run
};

// Result of FindUpright(). Without a world, `reason` has the missing evidence.
struct UprightResult {
  std::optional<UprightWorld> world;
  std::string reason;
};

// Finds the direction of gravity from horizontal planes and walls of a map.
//
// The mean upward (-y) axis of the cameras is the first estimate. It can be wrong by 45 degrees.
// The normals of surfels narrow it to the dominant direction. Then planes are fitted: horizontal
// planes that face up or down, and walls. With the unit normal n_i of a plane and the inertia a_i
// of its points along the plane, the direction g minimises
//   sum over horizontal planes of a_i |n_i x g|^2 + sum over walls of a_j (n_j . g)^2.
// The standard deviation is computed from the scatter of the planes, and is at least 0.1 degrees.
//
// The floor is the lowest large plane that faces up, below most cameras. It is at z = 0. The x and
// y axes are along the walls, with the smallest rotation about z from the axes of the run. The
// world origin of the run stays on the z axis.
//
// Gives no world if the cameras have no common upward direction, or if the standard deviation is
// above 1 degree. At least 0.3 m2 of horizontal planes and a floor below the cameras are necessary.
// `surfels` must be free of noise: ReliableSurfels().
UprightResult FindUpright(const std::vector<Surfel>& surfels, const Trajectory& cameras);

}  // namespace surfit
