#pragma once

#include <random>

#include "surfit/registration/correspondences.h"
#include "testing/random_pose.h"

namespace surfit::testing {

// Pairs as in a room: points within a cube of 2 m around `center`, residuals of `noise_m`, normals
// to all sides, weights from 1 to 3.
inline Correspondences RandomCorrespondences(int count, double noise_m, std::mt19937_64* rng,
                                             const Eigen::Vector3d& center = {0, 0, 3}) {
  Correspondences pairs;
  std::uniform_real_distribution<double> weight(1, 3);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p = center + RandomVector(1, rng);
    const Eigen::Vector3d q = p + RandomVector(noise_m, rng);
    const Eigen::Vector3d n = RandomVector(1, rng).normalized();
    pairs.Add(p, q, n, weight(*rng));
  }
  return pairs;
}

inline Eigen::Vector3d PointOf(const Correspondences& c, std::size_t i) {
  return {c.px[i], c.py[i], c.pz[i]};
}
inline Eigen::Vector3d TargetOf(const Correspondences& c, std::size_t i) {
  return {c.qx[i], c.qy[i], c.qz[i]};
}
inline Eigen::Vector3d NormalOf(const Correspondences& c, std::size_t i) {
  return {c.nx[i], c.ny[i], c.nz[i]};
}

}  // namespace surfit::testing
