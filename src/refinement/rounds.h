#pragma once

#include <functional>
#include <vector>

#include "refinement/motion_prior.h"

namespace surfit {

void TakePoses(const JointState& state, std::vector<RefinementKeyframe>* keyframes);

// Makes surfels from the keyframes, moves all, and again, until a round gains nothing. State and
// keyframes are where they were if it fails. Appends the rounds, and calls progress after each.
RefinementTermination RunRounds(const RefinementOptions& options,
                                std::vector<RefinementKeyframe>* keyframes, MotionPrior* prior,
                                JointState* state, std::vector<RefinementRound>* rounds,
                                const std::function<void(const RefinementRound&)>& progress);

}  // namespace surfit
