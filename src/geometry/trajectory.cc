#include "surfit/geometry/trajectory.h"

#include <algorithm>
#include <cmath>

namespace surfit {

std::optional<Rigid3d> InterpolatePose(const Trajectory& trajectory, double stamp_s,
                                       double max_gap_s, double max_difference_s) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  const bool has_after = after != trajectory.end(), has_before = after != trajectory.begin();
  if (has_after && after->stamp_s == stamp_s) return after->world_from_camera;
  if (has_after && has_before && after->stamp_s - std::prev(after)->stamp_s <= max_gap_s) {
    const StampedPose &a = *std::prev(after), &b = *after;
    const double share = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
    const Rigid3d &p = a.world_from_camera, &q = b.world_from_camera;
    return Rigid3d(p.rotation.slerp(share, q.rotation),
                   (1 - share) * p.translation + share * q.translation);
  }
  const auto near = [&](const StampedPose& pose) {
    return std::abs(pose.stamp_s - stamp_s) <= max_difference_s;
  };
  const bool near_after = has_after && near(*after);
  const bool near_before = has_before && near(*std::prev(after));
  if (near_after && near_before) {
    const bool before_is_nearer = stamp_s - std::prev(after)->stamp_s < after->stamp_s - stamp_s;
    return (before_is_nearer ? std::prev(after) : after)->world_from_camera;
  }
  if (near_after) return after->world_from_camera;
  if (near_before) return std::prev(after)->world_from_camera;
  return std::nullopt;
}

namespace {

struct Candidate {
  double difference_s;
  StampMatch match;
};

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

// Sorts both indices. Matches that cross exchange their partners. This does not increase the larger
// of their differences, so all differences stay within the limit.
std::vector<StampMatch> InOrder(std::vector<StampMatch> matches) {
  std::sort(matches.begin(), matches.end(),
            [](const StampMatch& a, const StampMatch& b) { return a.first < b.first; });
  std::vector<int> second;
  second.reserve(matches.size());
  for (const StampMatch& match : matches) second.push_back(match.second);
  std::sort(second.begin(), second.end());
  for (std::size_t i = 0; i < matches.size(); ++i) matches[i].second = second[i];
  return matches;
}

}  // namespace

std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s, double max_difference_s) {
  auto candidates = FindCandidates(first_s, second_s, max_difference_s);
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
  return InOrder(std::move(matches));
}

}  // namespace surfit
