#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mesh/surface/surfel_cubes.h"

namespace surfit {

// Weight of a surfel at a distance d below its support: w = (1 - d^2 / support^2)^2 / sigma^2.
// Farther away, w is 0.
struct SurfelKernel {
  float square, per_square, scale;  // support^2, 1 / support^2, 1 / sigma^2

  SurfelKernel(const MeshSurfel& surfel, float support_m)
      : square(support_m * support_m),
        per_square(1 / square),
        scale(1 / (surfel.sigma_m * surfel.sigma_m)) {}
  float Weight(float squared_distance) const {
    const float share = std::max(0.f, 1 - squared_distance * per_square);
    return scale * share * share;
  }
};

// Signed distance to the surface at the points of a grid, positive on the observed side. Implicit
// moving least squares (Kolluri 2005),
//   f(x) = sum w_i(x) n_i . (x - p_i) / sum w_i(x),
// with the weights of SurfelKernel. NaN without surfels near x. Points are stored in blocks. p_i,
// n_i: position and normal of surfel i. Point (x, y, z) of the grid is at cell_m times its integer
// coordinates. A block has kSide points per axis, and exists only near surfels. Const functions are
// thread-safe.
class DistanceField {
 public:
  static constexpr int kSide = 8;
  static constexpr int kPoints = kSide * kSide * kSide;
  // Block with a border of one point: indices -1 to kSide.
  static constexpr int kWide = kSide + 2;
  using WideBlock = std::array<float, kWide * kWide * kWide>;

  // Requires surfels in cubes of kSide cells. `done` as for SmoothSurfels(). Does not keep
  // `surfels`.
  DistanceField(const SurfelCubes& surfels, float cell_m, const std::function<void(double)>& done);

  float cell_m() const { return cell_m_; }
  // Support of a surfel, and the largest support of all surfels, m.
  float SupportOf(const MeshSurfel& surfel) const {
    return std::max(surfel.reach_m, kFewestCells * cell_m_);
  }
  float support_m() const { return support_m_; }

  int block_count() const { return static_cast<int>(keys_.size()); }
  // Block coordinates, in units of kSide points.
  Cube BlockAt(int i) const { return CubeKey::ToCube(keys_[i]); }
  // Index of a block; -1 if it does not exist.
  int FindBlock(const Cube& block) const;
  // Position of a grid point, m.
  Eigen::Vector3f PointAt(const Cube& point) const { return point.cast<float>() * cell_m_; }
  // Loads block i with its border. NaN in missing blocks. Value (x, y, z), each from -1 to kSide,
  // is at ((z + 1) kWide + y + 1) kWide + x + 1.
  void Load(int i, WideBlock* values) const;

 private:
  // Includes all corners of the cells that a plane cuts.
  static constexpr float kFewestCells = 2.5f;
  using Values = std::array<float, kPoints>;

  void FindBlocks(const SurfelCubes& surfels);
  std::unique_ptr<Values> Compute(int i, const SurfelCubes& surfels,
                                  std::vector<SurfelCubes::Range>* ranges) const;
  void Add(const MeshSurfel& surfel, const Eigen::Vector3f& origin, Values* weights,
           Values* distances) const;

  float cell_m_;
  float support_m_ = 0;
  std::vector<std::uint64_t> keys_;  // ascending
  std::vector<std::unique_ptr<Values>> values_;
};

}  // namespace surfit
