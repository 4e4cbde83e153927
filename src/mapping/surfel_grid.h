#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/merge_gate.h"

namespace surfit {

// A surfel where others look for it.
struct GridSurfel {
  Patch patch = {};
  std::int32_t id = 0;
  std::int32_t last_seen = 0;
};

// Surfels within a box, sorted into cubes of it, for those who look for near ones.
class SurfelGrid {
 public:
  // Cubes are as large as that, or larger where there would be too many. Surfels outside of the box
  // must not be among them.
  SurfelGrid(const Eigen::Vector3f& low, const Eigen::Vector3f& high, float cube_m,
             const std::vector<GridSurfel>& surfels)
      : low_(low), sorted_(surfels.size()) {
    const float longest = (high - low).maxCoeff();
    per_metre_ = 1 / std::max(cube_m, longest / kMostCubes);
    size_ = CubeAt(high) + Cube::Ones();
    std::vector<int> cube_of(surfels.size());
    begin_.assign(size_.prod() + 1, 0);
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      const Patch& p = surfels[i].patch;
      cube_of[i] = IndexOf(CubeAt({p.x, p.y, p.z}));
      ++begin_[cube_of[i] + 1];
    }
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < surfels.size(); ++i) sorted_[next[cube_of[i]]++] = surfels[i];
  }

  // Calls f(surfel) for all that are no farther from a position than a margin along each axis, and
  // for some beyond.
  template <typename F>
  void ForEachAround(const Eigen::Vector3f& position, const Eigen::Vector3f& margin,
                     const F& f) const {
    const Cube from = CubeAt(position - margin).cwiseMax(0);
    const Cube to = CubeAt(position + margin).cwiseMin(size_ - Cube::Ones());
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        const int end = begin_[IndexOf({to.x(), y, z}) + 1];
        for (int i = begin_[IndexOf({from.x(), y, z})]; i < end; ++i) f(sorted_[i]);
      }
    }
  }

 private:
  using Cube = Eigen::Vector3i;
  static constexpr int kMostCubes = 64;  // along each axis

  Cube CubeAt(const Eigen::Vector3f& position) const {
    return (per_metre_ * (position - low_)).array().floor().cast<int>();
  }
  int IndexOf(const Cube& cube) const {
    return (cube.z() * size_.y() + cube.y()) * size_.x() + cube.x();
  }

  Eigen::Vector3f low_;
  float per_metre_ = 0;
  Cube size_ = Cube::Ones();
  std::vector<GridSurfel> sorted_;
  std::vector<int> begin_;  // of each cube in sorted_, and the end of the last
};

}  // namespace surfit
