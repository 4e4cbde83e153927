#pragma once

namespace surfit {

// How far observations are from the surfels at their best numbers.
struct JointFit {
  double rho = 0;                  // the sum: twice the cost
  double weight = 0;               // the sum of rho' of planes
  double squared_sigmas = 0;       // the sums, so weighted, of r^2
  double squared_metres = 0;       // and of the squared distances of points to planes
  double texture_weight = 0;       // the sum of rho' of differences of intensity
  double squared_differences = 0;  // the sum, so weighted, of their squared errors

  JointFit& operator+=(const JointFit& other) {
    rho += other.rho;
    weight += other.weight;
    squared_sigmas += other.squared_sigmas;
    squared_metres += other.squared_metres;
    texture_weight += other.texture_weight;
    squared_differences += other.squared_differences;
    return *this;
  }
};

}  // namespace surfit
