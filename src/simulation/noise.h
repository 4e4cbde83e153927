#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "simulation/random.h"

namespace surfit {

// A random number in [0, 1) for a lattice point.
inline float LatticeValue(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  const std::uint64_t key = static_cast<std::uint64_t>(x) * 0x8da6b343u +
                            static_cast<std::uint64_t>(y) * 0xd8163841u +
                            static_cast<std::uint64_t>(z) * 0xcb1ab31fu + seed;
  return static_cast<float>(Random::Mix(key) >> 40) * 0x1p-24f;
}

// Value noise in [0, 1), smooth, with features of size 1.
inline float ValueNoise(const Eigen::Vector3d& point, std::uint64_t seed) {
  const Eigen::Array3d base = point.array().floor();
  const Eigen::Array3f f = (point.array() - base).cast<float>();
  const Eigen::Array3f s = f * f * (3 - 2 * f);
  const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()),
             z = static_cast<std::int64_t>(base.z());
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const auto along_x = [&](int j, int k) {
    return mix(LatticeValue(x, y + j, z + k, seed), LatticeValue(x + 1, y + j, z + k, seed), s.x());
  };
  return mix(mix(along_x(0, 0), along_x(1, 0), s.y()), mix(along_x(0, 1), along_x(1, 1), s.y()),
             s.z());
}

// Three octaves of value noise in [0, 1).
inline float FractalNoise(const Eigen::Vector3d& point, std::uint64_t seed) {
  return (4 * ValueNoise(point, seed) + 2 * ValueNoise(2.03 * point, seed + 1) +
          ValueNoise(4.07 * point, seed + 2)) /
         7;
}

}  // namespace surfit
