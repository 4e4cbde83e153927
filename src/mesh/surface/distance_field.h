#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mesh/surface/surfel_cubes.h"

namespace surfit {

// How much a surfel counts at a place: w = (1 - d^2 / support^2)^2 / sigma^2 at a distance of d.
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

// The signed distance to the surface, positive on the side that was seen, at the points of a grid:
// an implicit moving least squares (Kolluri 2005),
//   f(x) = sum w_i(x) n_i . (x - p_i) / sum w_i(x),
// by the kernels of the surfels near x, and NaN where there are none. Points are in blocks.
class DistanceField {
 public:
  static constexpr int kSide = 8;  // points along a block's side
  static constexpr int kPoints = kSide * kSide * kSide;
  // A block with one further point on each side: from -1 to kSide.
  static constexpr int kWide = kSide + 2;
  using WideBlock = std::array<float, kWide * kWide * kWide>;

  // Surfels in cubes of kSide cells. `done` is called from any thread with a share of the work.
  DistanceField(const SurfelCubes& surfels, float cell_m, const std::function<void(double)>& done);

  float cell_m() const { return cell_m_; }
  // How far a surfel's kernel reaches: over the points around each place that it supports.
  float SupportOf(const MeshSurfel& surfel) const {
    return std::max(surfel.reach_m, kFewestCells * cell_m_);
  }
  // The farthest of all.
  float support_m() const { return support_m_; }

  int block_count() const { return static_cast<int>(keys_.size()); }
  Cube BlockAt(int i) const { return CubeKey::ToCube(keys_[i]); }
  // -1 where there is none.
  int FindBlock(const Cube& block) const;
  // The place of a grid point.
  Eigen::Vector3f PointAt(const Cube& point) const { return point.cast<float>() * cell_m_; }
  // With NaN in blocks that are not there.
  void Load(int i, WideBlock* values) const;

 private:
  static constexpr float kFewestCells = 2.5f;  // all corners of the cells that a plane cuts
  using Values = std::array<float, kPoints>;   // x first

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
