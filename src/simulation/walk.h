#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "simulation/random.h"
#include "simulation/wander.h"

namespace surfit {

// Points at equal or slowly varying distances along a curve through a box.
class Walk {
 public:
  Walk(const Eigen::AlignedBox3d& space, Random* random)
      : center_(space.center()), half_(space.sizes() / 2), curve_(0.05, 0.16, random) {}

  Eigen::Vector3d Position() const { return At(place_); }

  // Goes on to the next point of the curve at this distance.
  void Advance(double step_m) {
    const Eigen::Vector3d from = Position();
    const auto too_near = [&](double place) { return (At(place) - from).norm() < step_m; };
    double low = place_, stride = 1e-3;
    while (too_near(low + stride)) low += stride;
    for (int i = 0; i < 40; ++i) {
      stride /= 2;
      if (too_near(low + stride)) low += stride;
    }
    place_ = low + stride;
  }

 private:
  Eigen::Vector3d At(double place) const { return center_ + half_.cwiseProduct(curve_.At(place)); }

  Eigen::Vector3d center_, half_;
  Wander3 curve_;
  double place_ = 0;
};

}  // namespace surfit
