#pragma once

#include <optional>

#include "io/files/places_file.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {

// Error of a measured relative pose of two keyframes, which are given by index in
// RunPlaces::keyframes. Interpolates the ground truth at their timestamps, with the default limits
// of MatchOptions. Returns std::nullopt if one of the keyframes has no ground truth.
std::optional<PoseError> ErrorOfLink(const Trajectory& ground_truth, const RunPlaces& source,
                                     int source_keyframe, const RunPlaces& target,
                                     int target_keyframe, const Rigid3d& target_from_source);

// Replaces `worst` if `error` has a larger translation error, or if `worst` is empty. An empty
// `error` changes nothing.
void UpdateMaximum(const std::optional<PoseError>& error, std::optional<PoseError>* worst);

}  // namespace surfit
