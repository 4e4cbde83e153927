#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// What a mesh is made of: a disc with what is known about it.
struct MeshSurfel {
  Eigen::Vector3f position;  // metres
  Eigen::Vector3f normal;    // unit length
  float spacing_m = 0;       // of surfels around it
  float reach_m = 0;         // the surface goes on so far beside it
  float sigma_m = 0;         // standard deviation along the normal
  Rgb8 color;
};

using Cube = Eigen::Vector3i;  // its place in a grid of cubes from the origin on

// Cubes as numbers in the order of z, y, x. Coordinates are within +-2^20.
class CubeKey {
 public:
  static constexpr int kMostCubes = 1 << 20;

  static std::uint64_t Of(const Cube& cube) {
    return Part(cube.z()) << 42 | Part(cube.y()) << 21 | Part(cube.x());
  }
  static Cube ToCube(std::uint64_t key) {
    const auto part = [&](int shift) {
      return static_cast<int>(key >> shift & 0x1fffff) - kMostCubes;
    };
    return {part(0), part(21), part(42)};
  }

 private:
  static std::uint64_t Part(int i) { return static_cast<std::uint32_t>(i + kMostCubes); }
};

// Surfels sorted into the cubes of a grid, those of a cube in their former order.
class SurfelCubes {
 public:
  struct Range {
    std::uint32_t begin, end;
  };

  // Throws InputError if surfels are farther than CubeKey::kMostCubes cubes from the origin.
  SurfelCubes(const std::vector<MeshSurfel>& surfels, float cube_m);

  float cube_m() const { return cube_m_; }
  const std::vector<MeshSurfel>& surfels() const { return surfels_; }
  // Where each of them stood before.
  const std::vector<std::uint32_t>& order() const { return order_; }

  // The cubes that hold surfels, by their keys in ascending order.
  int cube_count() const { return static_cast<int>(keys_.size()); }
  Cube CubeOf(int i) const { return CubeKey::ToCube(keys_[i]); }
  Range SurfelsOf(int i) const { return {begin_[i], begin_[i + 1]}; }

  // Replaces `ranges` by those of all surfels in cubes that touch the box, which are all surfels in
  // it and some beyond.
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
  std::vector<std::uint32_t> begin_;  // of each cube, and the end of the last
};

}  // namespace surfit
