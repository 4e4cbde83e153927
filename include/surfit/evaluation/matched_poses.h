#pragma once

#include <vector>

#include "surfit/geometry/trajectory.h"

namespace surfit {

// Which poses belong to the same moment.
struct MatchOptions {
  // Stamps further apart never match. evo's default; the TUM scripts use 0.02.
  double max_difference_s = 0.01;

  // Throws InputError naming the field, its value and the constraint.
  void Validate() const;
};

// What the ground truth and the estimate say of the same moment, each in its own world.
struct MatchedPose {
  double stamp_s = 0;  // the estimate's
  Rigid3d ground_truth;
  Rigid3d estimate;
};

// In order of time. Ground truth is taken at its nearest stamp, without interpolation, as the TUM
// scripts and evo do.
std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options);

std::vector<double> Stamps(const Trajectory& trajectory);

}  // namespace surfit
