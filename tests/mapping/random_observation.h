#pragma once

#include <random>

#include "mapping/random_surfel.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

inline constexpr float kNoCap = 1e9f;  // of confidence

inline Eigen::Vector3d ColorAsVector(Rgb8 color) {
  return {1. * color.r, 1. * color.g, 1. * color.b};
}

inline SurfelObservation RandomObservation(std::mt19937_64* rng) {
  SurfelObservation seen;
  for (float& x : seen.position_in_world) x = Uniform(-3, 3, rng);
  seen.normal_in_world = RandomNormal(0.5f, rng);
  seen.color = ColorAsVector(RandomColor(rng)).cast<float>();
  seen.radius_m = Uniform(0.001f, 0.02f, rng);
  seen.weight = seen.shape_weight = seen.color_weight = Uniform(0.2f, 1, rng);
  return seen;
}

// The stored colour in steps of a byte.
inline Eigen::Vector3d StoredColor(const SurfelMap& map, std::int32_t id) {
  const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
  const int k = id % SurfelBlock::kCapacity;
  return Eigen::Vector3d(block.red[k], block.green[k], block.blue[k]) / 256;
}

}  // namespace surfit::testing
