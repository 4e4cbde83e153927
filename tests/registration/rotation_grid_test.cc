#include "registration/start_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "surfit/geometry/rigid3.h"

namespace surfit {
namespace {

constexpr double kDegree = M_PI / 180;

TEST(RotationGrid, StartsWithNoneAndReaches60Degrees) {
  const std::vector<Eigen::Quaterniond> grid = RotationGrid();
  EXPECT_EQ(RotationAngle(grid.front()), 0);
  for (std::size_t i = 1; i < grid.size(); ++i) {
    EXPECT_GE(RotationAngle(grid[i]), RotationAngle(grid[i - 1]) - 1e-9);
  }
  EXPECT_LE(RotationAngle(grid.back()), 60 * kDegree + 1e-9);
}

// The angle between two rotations is no larger than the distance of their vectors, and what is
// farthest from a body-centred lattice of cubes of 19 degrees is 19 sqrt(5) / 4 = 10.6 degrees
// away.
TEST(RotationGrid, HasARotationNearAny) {
  const std::vector<Eigen::Quaterniond> grid = RotationGrid();
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> side(-28 * kDegree, 28 * kDegree);  // |w| < 49 degrees
  for (int i = 0; i < 1000; ++i) {
    const auto any = QuaternionExp<double>({side(generator), side(generator), side(generator)});
    double nearest_rad = M_PI;
    for (const Eigen::Quaterniond& rotation : grid) {
      nearest_rad = std::min(nearest_rad, RotationAngle(rotation.conjugate() * any));
    }
    EXPECT_LE(nearest_rad, 10.7 * kDegree);
  }
}

}  // namespace
}  // namespace surfit
