#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace surfit {

// Graduated non-convexity with truncated least squares: min(e^2, c^2) of each loop's squared error
// e^2 is reached from a convex surrogate by a control parameter mu that grows by 1.4 a round. Yang,
// Antonante, Tzoumas, Carlone: Graduated Non-Convexity for Robust Spatial Perception, RA-L 2020,
// eq. 12 to 14 and remark 5; r^2 there is e^2 here.
class LoopWeights {
 public:
  // max_squared_error is c^2; squared_errors are those of all loops at the start. That is odometry
  // here, not the paper's minimum of all weights 1: wrong loops fold a trajectory so that it stays
  // folded.
  LoopWeights(double max_squared_error, const std::vector<double>& squared_errors)
      : max_squared_error_(max_squared_error) {
    double largest = 0;
    for (const double error : squared_errors) largest = std::max(largest, error);
    all_fit_ = largest <= max_squared_error;
    if (!all_fit_) mu_ = max_squared_error / (2 * largest - max_squared_error);
  }

  // The weights, from 0 to 1, at the present mu, which then grows.
  std::vector<double> Update(const std::vector<double>& squared_errors) {
    std::vector<double> weights(squared_errors.size(), 1);
    if (all_fit_) return weights;
    std::transform(squared_errors.begin(), squared_errors.end(), weights.begin(),
                   [&](double error) { return Weight(error); });
    mu_ *= kGrowth;
    return weights;
  }

  // No loop's error is above the truncation from the start: all weights stay 1.
  bool AllFit() const { return all_fit_; }

 private:
  static constexpr double kGrowth = 1.4;

  double Weight(double squared_error) const {
    if (squared_error >= (mu_ + 1) / mu_ * max_squared_error_) return 0;
    if (squared_error <= mu_ / (mu_ + 1) * max_squared_error_) return 1;
    return std::clamp(std::sqrt(max_squared_error_ * mu_ * (mu_ + 1) / squared_error) - mu_, 0.,
                      1.);
  }

  double max_squared_error_;
  double mu_ = 0;
  bool all_fit_ = false;
};

// Every weight is 0 or 1.
inline bool AreBinary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0 || w == 1; });
}

}  // namespace surfit
