#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "simulation/loop.h"
#include "simulation/random.h"
#include "simulation/wander.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Points at equal or slowly varying distances along a curve: anywhere in the scene's camera space,
// or along its route with little swerves.
class Walk {
 public:
  Walk(const Scene& scene, Random* random)
      : center_(scene.camera_space.center()),
        half_(scene.camera_space.sizes() / 2),
        curve_(0.05, 0.16, random) {
    if (scene.route.empty()) return;
    loop_.emplace(scene.route);
    half_ = {0.1, 0.1, 0.15};
  }

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
  Eigen::Vector3d At(double place) const {
    return (loop_ ? loop_->At(place) : center_) + half_.cwiseProduct(curve_.At(place));
  }

  std::optional<Loop> loop_;
  Eigen::Vector3d center_, half_;  // of the box, or of the swerves
  Wander3 curve_;
  double place_ = 0;
};

}  // namespace surfit
