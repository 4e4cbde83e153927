#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// What is said of a set of errors, in their unit.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double p90 = 0;  // 90 % of the errors are at most this
  double max = 0;
};

// Errors are finite, not negative and at least one. Between two ranks the quantiles interpolate
// linearly, as numpy's do.
ErrorStatistics Summarize(std::vector<double> errors);

}  // namespace surfit
