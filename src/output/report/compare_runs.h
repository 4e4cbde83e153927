#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Rigid transform between the world frames of two runs.
struct RunAlignment {
  Rigid3d target_from_source;
  std::size_t poses = 0;  // number of compared poses
  double rms_m = 0;       // of the position differences after alignment
};

// Aligns two runs by the positions of poses at the same time. Poses of `target` are interpolated at
// the timestamps of `source`, with the default limits of MatchOptions. For an unobservable rotation
// (straight path), uses the pose pair in the middle. Returns std::nullopt for fewer than three pose
// pairs. Aborts if a position is not finite.
std::optional<RunAlignment> AlignRuns(const Trajectory& source, const Trajectory& target);

// Upper limit of DistancesFromMap(), m.
constexpr float kFarFromMap = 0.5f;
// Distance of each surfel centre to the disc of the map surfel with the nearest centre, m. At most
// kFarFromMap. kFarFromMap if the nearest centre is farther, for an empty map, and for non-finite
// positions.
std::vector<float> DistancesFromMap(const std::vector<Surfel>& surfels,
                                    const Rigid3d& map_from_surfels,
                                    const std::vector<Surfel>& map);

}  // namespace surfit
