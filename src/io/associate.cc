#include "io/associate.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace surfit {
namespace {

struct Candidate {
  double difference_s;
  AssociatedPair pair;
};

std::vector<Candidate> CandidatesByDifference(const std::vector<double>& first_s,
                                              const std::vector<double>& second_s,
                                              double max_difference_s) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < first_s.size(); ++i) {
    auto begin = std::lower_bound(second_s.begin(), second_s.end(), first_s[i] - max_difference_s);
    for (auto it = begin; it != second_s.end() && *it <= first_s[i] + max_difference_s; ++it) {
      const double difference_s = std::abs(*it - first_s[i]);
      if (difference_s >= max_difference_s) continue;
      const int j = static_cast<int>(it - second_s.begin());
      candidates.push_back({difference_s, {static_cast<int>(i), j}});
    }
  }
  const auto key = [](const Candidate& c) {
    return std::make_tuple(c.difference_s, c.pair.first, c.pair.second);
  };
  std::sort(candidates.begin(), candidates.end(),
            [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); });
  return candidates;
}

}  // namespace

std::vector<AssociatedPair> AssociateByTime(const std::vector<double>& first_s,
                                            const std::vector<double>& second_s,
                                            double max_difference_s) {
  std::vector<bool> first_used(first_s.size()), second_used(second_s.size());
  std::vector<AssociatedPair> pairs;
  for (const Candidate& c : CandidatesByDifference(first_s, second_s, max_difference_s)) {
    if (first_used[c.pair.first] || second_used[c.pair.second]) continue;
    first_used[c.pair.first] = second_used[c.pair.second] = true;
    pairs.push_back(c.pair);
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const AssociatedPair& a, const AssociatedPair& b) { return a.first < b.first; });
  return pairs;
}

}  // namespace surfit
