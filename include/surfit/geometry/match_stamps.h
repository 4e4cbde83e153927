#pragma once

#include <vector>

namespace surfit {

// Positions in two lists of stamps.
struct StampMatch {
  int first = 0;
  int second = 0;
};

// Pairs of stamps at most max_difference_s apart, both lists ascending: the nearest pair of all is
// taken first, and no stamp twice (associate.py of the TUM RGB-D benchmark, but for the limit
// itself, which matches here as in evo). Ascending in both.
std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s, double max_difference_s);

}  // namespace surfit
