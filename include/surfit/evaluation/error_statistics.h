#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// The value at a share, from 0 to 1, of the ascending order; between two ranks linearly
// interpolated, as numpy does. 0 of no values.
double Quantile(std::vector<double> values, double share);

// Statistics of a set of errors, in their unit.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double p90 = 0;  // 90 % of the errors are at most this
  double max = 0;
};

// Errors are finite, not negative and at least one.
ErrorStatistics Summarize(std::vector<double> errors);

}  // namespace surfit
