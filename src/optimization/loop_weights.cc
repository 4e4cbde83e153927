#include "optimization/loop_weights.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr double kGrowth = 1.4;

double Weight(double squared_error, double max_squared_error, double mu) {
  if (squared_error >= (mu + 1) / mu * max_squared_error) return 0;
  if (squared_error <= mu / (mu + 1) * max_squared_error) return 1;
  return std::clamp(std::sqrt(max_squared_error * mu * (mu + 1) / squared_error) - mu, 0., 1.);
}

}  // namespace

LoopWeights::LoopWeights(double max_squared_error, const std::vector<double>& squared_errors)
    : max_squared_error_(max_squared_error) {
  double largest = 0;
  for (const double error : squared_errors) largest = std::max(largest, error);
  all_fit_ = largest <= max_squared_error;
  if (!all_fit_) mu_ = max_squared_error / (2 * largest - max_squared_error);
}

std::vector<double> LoopWeights::Update(const std::vector<double>& squared_errors) {
  std::vector<double> weights(squared_errors.size(), 1);
  if (all_fit_) return weights;
  std::transform(squared_errors.begin(), squared_errors.end(), weights.begin(),
                 [&](double error) { return Weight(error, max_squared_error_, mu_); });
  mu_ *= kGrowth;
  return weights;
}

bool AreBinary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0 || w == 1; });
}

}  // namespace surfit
