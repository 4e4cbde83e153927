#include "registration/rotation_grid.h"

#include <algorithm>
#include <cmath>

#include "surfit/geometry/rigid3.h"

namespace surfit {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kReachRad = 60 * kDegree;
// The side of the lattice's cubes. What is farthest from all of its points is sqrt(5) / 4 of it.
constexpr double kSideRad = 19 * kDegree;

}  // namespace

std::vector<Eigen::Quaterniond> RotationGrid() {
  const int reach = static_cast<int>(kReachRad / kSideRad) + 1;
  std::vector<Eigen::Vector3d> vectors;
  for (const double offset : {0., 0.5}) {
    for (int x = -reach; x <= reach; ++x) {
      for (int y = -reach; y <= reach; ++y) {
        for (int z = -reach; z <= reach; ++z) {
          const Eigen::Vector3d vector =
              kSideRad * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(offset));
          if (vector.norm() <= kReachRad) vectors.push_back(vector);
        }
      }
    }
  }
  std::stable_sort(vectors.begin(), vectors.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  std::vector<Eigen::Quaterniond> rotations;
  rotations.reserve(vectors.size());
  for (const Eigen::Vector3d& vector : vectors) rotations.push_back(QuaternionExp<double>(vector));
  return rotations;
}

}  // namespace surfit
