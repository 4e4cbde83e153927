#pragma once

#include <vector>

namespace surfit {

// Graduated non-convexity with truncated least squares: min(e^2, c^2) of each loop's squared error
// e^2 is reached from a convex surrogate by a control parameter mu that grows by 1.4 a round. Yang,
// Antonante, Tzoumas, Carlone: Graduated Non-Convexity for Robust Spatial Perception, RA-L 2020,
// eq. 12 to 14 and remark 5; r^2 there is e^2 here.
class LoopWeights {
 public:
  // c^2 of truncation, and the squared errors of all loops at the start. That is odometry here, not
  // the paper's minimum of all weights 1: wrong loops fold a trajectory so that it stays folded.
  LoopWeights(double max_squared_error, const std::vector<double>& squared_errors);

  // The weights, from 0 to 1, at the present mu, which then grows.
  std::vector<double> Update(const std::vector<double>& squared_errors);

  // No loop's error is above the truncation from the start: all weights stay 1.
  bool AllFit() const { return all_fit_; }

 private:
  double max_squared_error_;
  double mu_ = 0;
  bool all_fit_ = false;
};

// Every weight is 0 or 1.
bool AreBinary(const std::vector<double>& weights);

}  // namespace surfit
