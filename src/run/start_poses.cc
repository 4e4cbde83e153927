#include "run/start_poses.h"

#include <random>

namespace surfit {
namespace {

Eigen::Vector3d RandomUnitVector(std::mt19937_64* rng) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Eigen::Vector3d vector;
  do {
    for (int i = 0; i < 3; ++i) vector[i] = coordinate(*rng);
  } while (vector.norm() > 1 || vector.norm() < 0.1);
  return vector.normalized();
}

}  // namespace

std::vector<GridCell> AllCells(int rotations, int translations) {
  std::vector<GridCell> cells;
  for (int i = 0; i < rotations; ++i) {
    for (int j = 0; j < translations; ++j) cells.push_back({i, j});
  }
  return cells;
}

Rigid3d Perturbed(const Rigid3d& target_from_source, double rotation_rad, double translation_m,
                  std::uint64_t seed) {
  if (rotation_rad == 0 && translation_m == 0) return target_from_source;  // bit for bit
  std::mt19937_64 rng(seed);
  Eigen::Matrix<double, 6, 1> increment;
  increment.head<3>() = rotation_rad * RandomUnitVector(&rng);
  increment.tail<3>() = translation_m * RandomUnitVector(&rng);
  return LeftIncrement<double>(increment, target_from_source);
}

}  // namespace surfit
