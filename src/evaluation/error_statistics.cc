#include "surfit/evaluation/error_statistics.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit {
namespace {

double QuantileOfSorted(const std::vector<double>& sorted, double share) {
  const double rank = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (rank - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return QuantileOfSorted(values, share);
}

ErrorStatistics Summarize(std::vector<double> errors) {
  ThrowIf(errors.empty(), "there are no errors to summarise");
  std::sort(errors.begin(), errors.end());
  double sum = 0, sum_of_squares = 0;
  for (const double error : errors) {
    sum += error;
    sum_of_squares += error * error;
  }
  const auto count = static_cast<double>(errors.size());
  ErrorStatistics s;
  s.count = errors.size();
  s.rmse = std::sqrt(sum_of_squares / count);
  s.mean = sum / count;
  s.median = QuantileOfSorted(errors, 0.5);
  s.p90 = QuantileOfSorted(errors, 0.9);
  s.max = errors.back();
  return s;
}

}  // namespace surfit
