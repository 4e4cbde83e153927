#pragma once

#include <algorithm>
#include <cmath>

namespace surfit {

// How far steps of Levenberg-Marquardt may go: their damping is divided by the radius. Changes as
// in Ceres (Madsen, Nielsen, Tingleff: Methods for non-linear least squares problems, 2004, 3.2).
class TrustRegion {
 public:
  explicit TrustRegion(double radius) : radius_(radius) {}

  double radius() const { return radius_; }

  // The cost fell by this share of what the linearised one promised.
  void Accept(double gain) {
    radius_ = std::min(kMaxRadius, radius_ / std::max(1. / 3, 1 - std::pow(2 * gain - 1, 3)));
    shrink_ = 2;
  }

  void Refuse() {
    radius_ /= shrink_;
    shrink_ *= 2;
  }

 private:
  static constexpr double kMaxRadius = 1e16;

  double radius_, shrink_ = 2;
};

}  // namespace surfit
