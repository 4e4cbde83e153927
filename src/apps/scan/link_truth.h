#pragma once

#include <optional>

#include "io/files/places_file.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {

// Error of a measured motion between two keyframes. Keyframes are given by position. Returns
// std::nullopt if the ground truth does not cover both keyframes.
std::optional<PoseError> ErrorOfLink(const Trajectory& ground_truth, const RunPlaces& source,
                                     int source_keyframe, const RunPlaces& target,
                                     int target_keyframe, const Rigid3d& target_from_source);

// Replaces `worst` if it is empty or has a smaller translation error.
void UpdateMaximum(const std::optional<PoseError>& error, std::optional<PoseError>* worst);

}  // namespace surfit
