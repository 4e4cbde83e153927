#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace surfit {

// Surfels by the cube of space that they are in, for those who look for near ones.
class SurfelGrid {
 public:
  // Nothing is looked for farther than this.
  explicit SurfelGrid(float reach_m) : per_metre_(1 / reach_m) {}

  bool empty() const { return ids_.empty(); }
  void Add(const Eigen::Vector3f& position, std::int32_t id) {
    ids_[Key(CubeOf(position))].push_back(id);
  }

  // Calls f(id) for all within reach of the position, and some beyond, cube by cube in the order in
  // which they were added.
  template <typename F>
  void ForEachAround(const Eigen::Vector3f& position, const F& f) const {
    const Cube middle = CubeOf(position);
    for (int i = 0; i < 27; ++i) {
      const Cube beside = {i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
      const auto at = ids_.find(Key(middle + beside));
      if (at == ids_.end()) continue;
      for (const std::int32_t id : at->second) f(id);
    }
  }

 private:
  using Cube = Eigen::Vector3i;

  Cube CubeOf(const Eigen::Vector3f& position) const {
    return (per_metre_ * position).array().floor().cast<int>();
  }
  // Cubes 2^21 apart share a key, which makes a search longer but not wrong.
  static std::uint64_t Key(const Cube& cube) {
    const auto bits = [](int i) { return static_cast<std::uint64_t>(i) & 0x1fffff; };
    return bits(cube.x()) << 42 | bits(cube.y()) << 21 | bits(cube.z());
  }

  float per_metre_;
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> ids_;
};

}  // namespace surfit
