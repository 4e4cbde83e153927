#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// How the world of a run lies in that of another one.
struct RunAlignment {
  Rigid3d target_from_source;
  std::size_t poses = 0;  // at equal stamps, that tell so
  double rms_m = 0;       // of what remains between their positions
};

// By the poses of equal stamps: the rigid motion that brings their positions together best. Where
// that leaves a rotation open, as along a straight path, the pose in the middle decides. Nothing
// where fewer than three stamps are equal.
std::optional<RunAlignment> AlignRuns(const Trajectory& source, const Trajectory& target);

// How far each surfel's centre is from a map: from the disc of the map's surfel whose centre is
// nearest, in metres. kFarFromMap where no centre is within that.
constexpr float kFarFromMap = 0.5f;
std::vector<float> DistancesFromMap(const std::vector<Surfel>& surfels,
                                    const Rigid3d& map_from_surfels,
                                    const std::vector<Surfel>& map);

}  // namespace surfit
