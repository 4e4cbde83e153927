#pragma once

#include <random>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit::testing {

// Uniform in the cube [-size, size]^3.
inline Eigen::Vector3d RandomVector(double size, std::mt19937_64* rng) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(*rng), y = uniform(*rng), z = uniform(*rng);
  return {x, y, z};
}

// A pose with a uniform rotation vector and translation.
inline Rigid3d RandomPose(double size_rad, double size_m, std::mt19937_64* rng) {
  const Eigen::Quaterniond rotation = QuaternionExp<double>(RandomVector(size_rad, rng));
  return {rotation, RandomVector(size_m, rng)};
}

// Positive and negative increments along the three rotations and translations.
inline std::vector<Rigid3d::Vector6> EachDirection(double turn_rad, double shift_m) {
  std::vector<Rigid3d::Vector6> increments;
  for (int axis = 0; axis < 6; ++axis) {
    const double size = axis < 3 ? turn_rad : shift_m;
    for (const double step : {-size, size})
      increments.push_back(step * Rigid3d::Vector6::Unit(axis));
  }
  return increments;
}

}  // namespace surfit::testing
