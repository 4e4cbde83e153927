#pragma once

#include <random>

#include "surfit/registration/association.h"
#include "testing/random_pose.h"

namespace surfit::testing {

// Correspondences as in a room: points in a cube of 2 m around `center`, residuals of `noise_m` and
// information of 1 to 3 per m^2. Normals are random, and differ slightly between source and target.
inline Correspondences RandomCorrespondences(int count, double noise_m, std::mt19937_64* rng,
                                             const Eigen::Vector3d& center = {0, 0, 3}) {
  Correspondences pairs;
  std::uniform_real_distribution<double> information(1, 3);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p = center + RandomVector(1, rng);
    const Eigen::Vector3d q = p + RandomVector(noise_m, rng);
    const Eigen::Vector3d n = RandomVector(1, rng).normalized();
    const Eigen::Vector3d m = (n + RandomVector(0.1, rng)).normalized();
    pairs.Add(p, q, n, m, information(*rng));
  }
  return pairs;
}

// Correspondences whose target points and normals are the transformed source.
inline Correspondences ExactCorrespondences(int count, const Rigid3d& motion,
                                            std::mt19937_64* rng) {
  const Correspondences random = RandomCorrespondences(count, 0, rng);
  Correspondences pairs;
  for (int i = 0; i < count; ++i) {
    pairs.Add(random.p(i), motion * random.p(i), motion.rotation * random.m(i), random.m(i),
              random.information[i]);
  }
  return pairs;
}

template <typename S>
Pairs<S> Rounded(const Correspondences& pairs) {
  Pairs<S> rounded;
  for (int i = 0; i < pairs.size; ++i) {
    rounded.Add(pairs.p(i).cast<S>(), pairs.q(i).cast<S>(), pairs.n(i).cast<S>(),
                pairs.m(i).cast<S>(), static_cast<S>(pairs.information[i]));
  }
  return rounded;
}

inline Correspondences AsDouble(const PairBuffer& pairs) {
  Correspondences result;
  for (int i = 0; i < pairs.size; ++i) {
    result.Add(pairs.p(i).cast<double>(), pairs.q(i).cast<double>(), pairs.n(i).cast<double>(),
               pairs.m(i).cast<double>(), pairs.information[i]);
  }
  return result;
}

}  // namespace surfit::testing
