#pragma once

#include <optional>

#include "io/files/places_file.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {

// By how much a measured motion between two keyframes misses the true one; nothing where the ground
// truth does not know both. Keyframes by their positions.
std::optional<PoseError> ErrorOfLink(const Trajectory& ground_truth, const RunPlaces& source,
                                     int source_keyframe, const RunPlaces& target,
                                     int target_keyframe, const Rigid3d& target_from_source);

// Of two errors the one that is farther, or the one there is.
void KeepWorse(const std::optional<PoseError>& error, std::optional<PoseError>* worst);

}  // namespace surfit
