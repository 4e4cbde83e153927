#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Surfel for meshing. Before FindSigmas(), `sigma_m` is relative.
struct MeshSurfel {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f normal;    // unit length
  float spacing_m = 0;       // spacing of the surfels around it
  float reach_m = 0;         // tangential radius within which the surfel supports the surface
  float sigma_m = 0;         // standard deviation along the normal
  Rgb8 color;
};

using Cube = Eigen::Vector3i;

// Integer coordinates of a cube, sorted by z, y, x. Coordinates are within +-2^20. Other
// coordinates are not checked.
class CubeKey {
 public:
  static constexpr int kMaxCubes = 1 << 20;

  static std::uint64_t Of(const Cube& cube) {
    return Part(cube.z()) << 42 | Part(cube.y()) << 21 | Part(cube.x());
  }
  static Cube ToCube(std::uint64_t key) {
    const auto part = [&](int shift) {
      return static_cast<int>(key >> shift & 0x1fffff) - kMaxCubes;
    };
    return {part(0), part(21), part(42)};
  }

 private:
  static std::uint64_t Part(int i) { return static_cast<std::uint32_t>(i + kMaxCubes); }
};

// Copy of surfels, sorted by the cube that contains them. Keeps the order within a cube. Const
// functions are thread-safe.
class SurfelCubes {
 public:
  struct Range {
    std::uint32_t begin, end;
  };

  // `cube_m`: edge length. Throws InputError if a point is too far from the origin for CubeKey.
  SurfelCubes(const std::vector<MeshSurfel>& surfels, float cube_m);

  float cube_m() const { return cube_m_; }
  // Sorted surfels, and the input index of each.
  const std::vector<MeshSurfel>& surfels() const { return surfels_; }
  const std::vector<std::uint32_t>& order() const { return order_; }

  // Number of non-empty cubes, which are sorted by key.
  int cube_count() const { return static_cast<int>(keys_.size()); }
  Cube CubeOf(int i) const { return CubeKey::ToCube(keys_[i]); }
  // Indices in surfels() of cube i, half-open.
  Range SurfelsOf(int i) const { return {begin_[i], begin_[i + 1]}; }

  // Replaces `ranges` by the surfels of all cubes that overlap the box. The ranges are half-open
  // indices in surfels().
  void FindWithin(const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                  std::vector<Range>* ranges) const;

 private:
  Cube CubeAt(const Eigen::Vector3f& position) const {
    return (position / cube_m_).array().floor().cast<int>();
  }

  float cube_m_;
  std::vector<MeshSurfel> surfels_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> begin_;
};

}  // namespace surfit
