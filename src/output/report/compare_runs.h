#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Alignment of the world frames of two runs.
struct RunAlignment {
  Rigid3d target_from_source;
  std::size_t poses = 0;  // number of pose pairs with equal timestamps
  double rms_m = 0;       // RMS distance of the aligned positions
};

// Aligns two runs by the positions of poses with equal timestamps. If the rotation is unobservable,
// for example on a straight path, the middle pose pair determines the transform. Returns
// std::nullopt for fewer than three equal timestamps.
std::optional<RunAlignment> AlignRuns(const Trajectory& source, const Trajectory& target);

// Distance of each surfel centre to the disc of the map surfel with the nearest centre, m. At most
// kFarFromMap.
constexpr float kFarFromMap = 0.5f;
std::vector<float> DistancesFromMap(const std::vector<Surfel>& surfels,
                                    const Rigid3d& map_from_surfels,
                                    const std::vector<Surfel>& map);

}  // namespace surfit
