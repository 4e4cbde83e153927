#include "surfit/evaluation/matched_poses.h"

#include "surfit/core/error.h"
#include "surfit/geometry/match_stamps.h"

namespace surfit {

void MatchOptions::Validate() const {
  if (!(max_difference_s >= 0 && max_difference_s <= 1)) {
    throw InputError(Concat("max_difference_s is ", max_difference_s, ", must be from 0 to 1"));
  }
}

std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options) {
  options.Validate();
  std::vector<MatchedPose> poses;
  for (const StampMatch& match :
       MatchStamps(Stamps(estimate), Stamps(ground_truth), options.max_difference_s)) {
    const StampedPose& e = estimate[match.first];
    poses.push_back({e.stamp_s, ground_truth[match.second].world_from_camera, e.world_from_camera});
  }
  return poses;
}

std::vector<double> Stamps(const Trajectory& trajectory) {
  std::vector<double> stamps;
  stamps.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) stamps.push_back(pose.stamp_s);
  return stamps;
}

}  // namespace surfit
