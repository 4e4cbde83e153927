#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// Quantile of finite values, linearly interpolated between ranks as in numpy. `share` in [0, 1] and
// the values are not checked. Returns 0 without values.
double Quantile(std::vector<double> values, double share);

// Statistics of a set of errors, in the unit of the errors.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double p90 = 0;  // 90 % quantile
  double max = 0;
};

// Computes statistics of finite, nonnegative errors, which are not checked. Throws if there are
// none.
ErrorStatistics Summarize(std::vector<double> errors);

}  // namespace surfit
