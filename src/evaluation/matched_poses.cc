#include "surfit/evaluation/matched_poses.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit {
namespace {

struct Candidate {
  double difference_s;
  StampMatch match;
};

// All pairs that are near enough, in order of first, then second.
std::vector<Candidate> FindCandidates(const std::vector<double>& first_s,
                                      const std::vector<double>& second_s, double max_s) {
  std::vector<Candidate> candidates;
  const int second_count = static_cast<int>(second_s.size());
  int begin = 0;
  for (int i = 0; i < static_cast<int>(first_s.size()); ++i) {
    while (begin < second_count && first_s[i] - second_s[begin] > max_s) ++begin;
    for (int j = begin; j < second_count && second_s[j] - first_s[i] <= max_s; ++j) {
      candidates.push_back({std::abs(first_s[i] - second_s[j]), {i, j}});
    }
  }
  return candidates;
}

}  // namespace

void MatchOptions::Validate() const {
  if (!(max_difference_s >= 0 && max_difference_s <= 1)) {
    throw InputError(Concat("max_difference_s is ", max_difference_s, ", must be from 0 to 1"));
  }
}

std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s,
                                    const MatchOptions& options) {
  options.Validate();
  auto candidates = FindCandidates(first_s, second_s, options.max_difference_s);
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.difference_s < b.difference_s; });
  std::vector<bool> first_taken(first_s.size()), second_taken(second_s.size());
  std::vector<StampMatch> matches;
  for (const Candidate& candidate : candidates) {
    const StampMatch match = candidate.match;
    if (first_taken[match.first] || second_taken[match.second]) continue;
    first_taken[match.first] = second_taken[match.second] = true;
    matches.push_back(match);
  }
  std::sort(matches.begin(), matches.end(),
            [](const StampMatch& a, const StampMatch& b) { return a.first < b.first; });
  return matches;
}

std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options) {
  std::vector<MatchedPose> poses;
  for (const StampMatch& match : MatchStamps(Stamps(estimate), Stamps(ground_truth), options)) {
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
