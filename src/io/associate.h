#pragma once

#include <vector>

namespace surfit {

struct AssociatedPair {
  int first = 0;   // index into the first list
  int second = 0;  // index into the second
};

// Pairs the times of two lists that are less than max_difference_s apart, each used at most once,
// closest pair first, as associate.py of the TUM RGB-D benchmark does. In ascending order of the
// first list's times. Both lists must be in ascending order.
std::vector<AssociatedPair> AssociateByTime(const std::vector<double>& first_s,
                                            const std::vector<double>& second_s,
                                            double max_difference_s);

}  // namespace surfit
