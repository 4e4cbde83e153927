#include "surfit/geometry/match_stamps.h"

#include <algorithm>
#include <cmath>

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
  std::sort(matches.begin(), matches.end(),
            [](const StampMatch& a, const StampMatch& b) { return a.first < b.first; });
  return matches;
}

}  // namespace surfit
