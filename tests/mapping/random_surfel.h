#pragma once

#include <random>

#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

inline float Uniform(float low, float high, std::mt19937_64* rng) {
  return std::uniform_real_distribution<float>(low, high)(*rng);
}

// A unit vector, evenly over the sphere's cap of this half angle about -z: towards a camera.
inline Eigen::Vector3f RandomNormal(float max_angle_rad, std::mt19937_64* rng) {
  const float z = -Uniform(std::cos(max_angle_rad), 1.f, rng);
  const float turn = Uniform(0.f, 6.2831853f, rng), across = std::sqrt(1 - z * z);
  return Eigen::Vector3f(across * std::cos(turn), across * std::sin(turn), z).normalized();
}

inline Rgb8 RandomColor(std::mt19937_64* rng) {
  const std::uint64_t bits = (*rng)();
  return {static_cast<std::uint8_t>(bits >> 56), static_cast<std::uint8_t>(bits >> 48),
          static_cast<std::uint8_t>(bits >> 40)};
}

// A surfel whose values all differ from those of any other, as far as chance goes.
inline Surfel RandomSurfel(std::mt19937_64* rng) {
  Surfel s;
  for (float& x : s.position_in_world) x = Uniform(-3, 3, rng);
  s.normal_in_world = RandomNormal(1, rng);
  s.color = RandomColor(rng);
  s.radius_m = Uniform(0.001f, 0.02f, rng);
  s.confidence = Uniform(0.1f, 20, rng);
  s.first_seen = static_cast<std::int32_t>((*rng)() % 50);
  s.last_seen = s.first_seen + static_cast<std::int32_t>((*rng)() % 50);
  s.at_edge = (*rng)() % 2 == 0;
  return s;
}

}  // namespace surfit::testing
