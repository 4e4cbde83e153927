#pragma once

#include <Eigen/Core>
#include <random>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

inline float Uniform(float low, float high, std::mt19937_64* rng) {
  return std::uniform_real_distribution<float>(low, high)(*rng);
}

// Uniform unit vector in the spherical cap with this half angle around -z, towards the camera.
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

// Values after storage in a map. Coordinates must be below 128 m.
inline float StoredCoordinate(float coordinate_m) {
  return SmallCoordinate::kStep * std::round(coordinate_m / SmallCoordinate::kStep);
}
inline float StoredLength(float length_m) {
  return SmallLength::ToFloat(SmallLength::From(length_m));
}
inline Eigen::Vector3f StoredNormal(const Eigen::Vector3f& normal) {
  SurfelBlock block;
  block.SetNormal(0, normal);
  return block.Normal(0);
}
// Maximum error of a stored normal.
inline constexpr double kNormalRounding = 0.87 / 32767;
// Maximum error of a stored position (m) and of a stored confidence: half a step.
inline constexpr double kPositionRounding = 0.87 / 65536;
inline constexpr double kConfidenceRounding = 0.5 / 256;

// Random surfel whose values are exact in storage.
inline Surfel RandomSurfel(std::mt19937_64* rng) {
  Surfel s;
  for (float& x : s.position_in_world) x = StoredCoordinate(Uniform(-3, 3, rng));
  s.normal_in_world = StoredNormal(RandomNormal(1, rng));
  s.color = RandomColor(rng);
  s.radius_m = StoredLength(Uniform(0.001f, 0.02f, rng));
  s.confidence = SmallSum::ToFloat(SmallSum::From(Uniform(0.1f, 20, rng)));
  s.first_seen = static_cast<std::int32_t>((*rng)() % 50);
  s.last_seen = s.first_seen + static_cast<std::int32_t>((*rng)() % 50);
  s.at_edge = (*rng)() % 2 == 0;
  s.color_weight = WeightByte::ToFloat(static_cast<std::uint8_t>(140 + (*rng)() % 50));
  return s;
}

inline PinholeCamera SmallCamera() { return {64, 48, 60, 61, 30.5, 24.25, {}}; }

// Surfel of a disc in the camera frame.
inline Surfel Disc(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float radius_m,
                   float confidence, const Rigid3d& world_from_camera = {}) {
  Surfel s;
  s.position_in_world = (world_from_camera * position.cast<double>()).cast<float>();
  s.normal_in_world = (world_from_camera.rotation * normal.cast<double>()).cast<float>();
  s.radius_m = radius_m;
  s.confidence = confidence;
  s.color = {10, 20, 30};
  return s;
}

// Discs inside the view, outside and behind the camera. Some face away, and half of them are
// unstable.
inline SurfelMap RandomDiscs(int count, float max_radius_m, const Rigid3d& world_from_camera,
                             std::mt19937_64* rng) {
  SurfelMap map;
  for (int i = 0; i < count; ++i) {
    const float z = Uniform(-0.5f, 3, rng);
    const Eigen::Vector3f position(z * Uniform(-0.7f, 0.7f, rng), z * Uniform(-0.5f, 0.5f, rng), z);
    Surfel s = Disc(position, RandomNormal(1.9f, rng), Uniform(0.01f, max_radius_m, rng),
                    Uniform(0, 20, rng), world_from_camera);
    s.color = RandomColor(rng);
    map.Append(s);
  }
  return map;
}

inline constexpr float kNoCap = 1e9f;  // no limit of confidence

inline Eigen::Vector3d ColorAsVector(Rgb8 color) {
  return {1. * color.r, 1. * color.g, 1. * color.b};
}

// Observation within 0.2 m of a surfel along each axis.
inline SurfelObservation RandomObservation(const Surfel& of, std::mt19937_64* rng) {
  SurfelObservation seen;
  for (int i = 0; i < 3; ++i) {
    seen.position_in_world[i] = of.position_in_world[i] + Uniform(-0.2f, 0.2f, rng);
  }
  seen.normal_in_world = RandomNormal(0.5f, rng);
  seen.color = ColorAsVector(RandomColor(rng)).cast<float>();
  seen.radius_m = StoredLength(Uniform(0.001f, 0.02f, rng));
  seen.weight = seen.shape_weight = seen.color_weight = Uniform(0.2f, 1, rng);
  return seen;
}

// Stored colour in byte steps.
inline Eigen::Vector3d StoredColor(const SurfelMap& map, std::int32_t id) {
  const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
  const int k = id % SurfelBlock::kCapacity;
  return block.FineColor(k).cast<double>();
}

}  // namespace surfit::testing
