#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "mapping/merge_gate.h"

namespace surfit {

// A surfel where others look for it.
struct GridSurfel {
  Patch patch = {};
  std::int32_t id = 0;
  std::int32_t last_seen = 0;
};

// Surfels within a box, sorted into cubes of it, for those who look for near ones: several of them
// at once, over lanes.
class SurfelGrid {
 public:
  // Cubes are as large as that, or larger where there would be too many. Surfels outside of the box
  // must not be among them.
  SurfelGrid(const Eigen::Vector3f& low, const Eigen::Vector3f& high, float cube_m,
             const std::vector<GridSurfel>& surfels)
      : low_(low), ids_(surfels.size()) {
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
    for (auto& numbers : numbers_) numbers.resize(surfels.size() + kPadding, kNowhere);
    for (std::size_t i = 0; i < surfels.size(); ++i) Set(next[cube_of[i]]++, surfels[i]);
  }

  // Calls f(begin, end) for places in the order that the surfels are sorted in. All that are no
  // farther from a position than a margin along each axis are at these, and some beyond.
  template <typename F>
  void ForEachRowAround(const Eigen::Vector3f& position, const Eigen::Vector3f& margin,
                        const F& f) const {
    const Cube from = CubeAt(position - margin).cwiseMax(0);
    const Cube to = CubeAt(position + margin).cwiseMin(size_ - Cube::Ones());
    for (int z = from.z(); z <= to.z(); ++z) {
      for (int y = from.y(); y <= to.y(); ++y) {
        const int begin = begin_[IndexOf({from.x(), y, z})];
        const int end = begin_[IndexOf({to.x(), y, z}) + 1];
        if (begin < end) f(begin, end);
      }
    }
  }

  // Of as many surfels as there are lanes, from a place on; those beyond the last are nowhere.
  template <typename Number>
  PatchOf<Number> Patches(int place) const {
    const auto load = [&](int i) { return Number::Load(&numbers_[i][place]); };
    return {load(0), load(1), load(2), load(3), load(4), load(5)};
  }
  // The frames in which these were last seen: whole numbers, exact up to 2^24.
  template <typename Number>
  Number LastSeen(int place) const {
    return Number::Load(&numbers_[6][place]);
  }
  std::int32_t Id(int place) const { return ids_[place]; }

 private:
  using Cube = Eigen::Vector3i;
  static constexpr int kMostCubes = 64;  // along each axis
  static constexpr int kPadding = 8;     // lanes that may be read beyond the last surfel
  static constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();  // near to nothing

  void Set(int place, const GridSurfel& surfel) {
    const Patch& p = surfel.patch;
    const float numbers[] = {p.x, p.y, p.z, p.nx, p.ny, p.nz, static_cast<float>(surfel.last_seen)};
    for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i][place] = numbers[i];
    ids_[place] = surfel.id;
  }

  Cube CubeAt(const Eigen::Vector3f& position) const {
    return (per_metre_ * (position - low_)).array().floor().cast<int>();
  }
  int IndexOf(const Cube& cube) const {
    return (cube.z() * size_.y() + cube.y()) * size_.x() + cube.x();
  }

  Eigen::Vector3f low_;
  float per_metre_ = 0;
  Cube size_ = Cube::Ones();
  std::array<std::vector<float>, 7> numbers_;  // x y z nx ny nz, last_seen
  std::vector<std::int32_t> ids_;
  std::vector<int> begin_;  // of each cube, and the end of the last
};

}  // namespace surfit
