#include "mapping/map/smooth_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "surfit/core/parallel.h"

namespace surfit::testing {
namespace {

constexpr float kPointsApart = 0.006f, kPointRadius = 0.006f;
constexpr int kPointsAside = 60;

// At 2 m, a pixel has the size kPointRadius / sqrt(2), and the depth noise is 8 mm.
DepthSensor Sensor() { return {{640, 480, 471.4, 471.4, 319.5, 239.5, {}}, {0.002}}; }

Surfel At(float x, float y, float z, const Eigen::Vector3f& normal) {
  Surfel surfel;
  surfel.position_in_world = {x, y, z};
  surfel.normal_in_world = normal.normalized();
  surfel.radius_m = kPointRadius;
  surfel.confidence = 4;
  return surfel;
}

// Wall at z(x) with noise along its normal, and noisy normals near (0, 0, -1).
template <typename F>
SurfelMap WallAt(const F& z, float noise_m, float noise_rad) {
  std::mt19937_64 random(1);
  std::normal_distribution<float> normal(0, 1);
  SurfelMap map;
  for (int i = 0; i < kPointsAside * kPointsAside; ++i) {
    const float x = kPointsApart * (i % kPointsAside), y = kPointsApart * (i / kPointsAside);
    const float tilt_x = noise_rad * normal(random), tilt_y = noise_rad * normal(random);
    map.Append(At(x, y, z(x) + noise_m * normal(random), {tilt_x, tilt_y, -1}));
  }
  return map;
}

// RMS of z - z(x), except within a margin of the ends of the wall.
template <typename F>
double DeviationFrom(const SurfelMap& map, const F& z) {
  double sum = 0, count = 0;
  for (const std::int32_t id : map.Ids()) {
    const Eigen::Vector3f p = map[id].position_in_world;
    if (p.x() < 0.03f || p.x() > kPointsApart * kPointsAside - 0.03f) continue;
    sum += std::pow(p.z() - z(p.x()), 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

double MeanTilt(const SurfelMap& map) {
  double sum = 0;
  for (const std::int32_t id : map.Ids()) sum += std::acos(-map[id].normal_in_world.z());
  return sum / static_cast<double>(map.size());
}

// 28 surfels are within 18 mm. Their Gaussian weights correspond to about 14 surfels.
TEST(SmoothMap, ReducesNoiseOfWall) {
  const auto flat = [](float) { return 2.f; };
  const SurfelMap noisy = WallAt(flat, 0.003f, 0.05f);
  SurfelMap map = noisy;
  SmoothMap(Sensor(), &map);
  EXPECT_LT(DeviationFrom(map, flat), DeviationFrom(noisy, flat) / 3);
  EXPECT_LT(MeanTilt(map), MeanTilt(noisy) / 3);
  ExpectConsistent(map);
}

// The step is 5 sigma of the noise after four measurements.
TEST(SmoothMap, KeepsStep) {
  const auto step = [](float x) { return x < 0.177f ? 2.f : 2.02f; };
  SurfelMap map = WallAt(step, 0, 0);
  SmoothMap(Sensor(), &map);
  EXPECT_LT(DeviationFrom(map, step), 0.0003);
  for (const std::int32_t id : map.Ids()) {
    EXPECT_NEAR(map[id].position_in_world.z(), step(map[id].position_in_world.x()), 0.002);
  }
}

TEST(SmoothMap, KeepsCrease) {
  SurfelMap map;
  for (int i = 0; i < kPointsAside * kPointsAside; ++i) {
    const float a = kPointsApart * (i % kPointsAside), y = kPointsApart * (i / kPointsAside);
    map.Append(At(a, y, 2, {0, 0, -1}));
    map.Append(At(0, y, 2 - a, {1, 0, 0}));
  }
  SmoothMap(Sensor(), &map);
  for (const std::int32_t id : map.Ids()) {
    const Eigen::Vector3f p = map[id].position_in_world;
    EXPECT_LT(std::min(std::abs(p.z() - 2), std::abs(p.x())), 1e-5f);
  }
}

TEST(SmoothMap, IgnoresSurfelsOfDepthEdges) {
  const auto flat = [](float) { return 2.f; };
  SurfelMap map = WallAt(flat, 0, 0);
  for (int i = 0; i < 200; ++i) {
    Surfel beside = At(0.15f + 0.0003f * static_cast<float>(i), 0.18f, 2.003f, {0, 0, -1});
    beside.at_edge = true;
    map.Append(beside);
  }
  SmoothMap(Sensor(), &map);
  for (const std::int32_t id : map.Ids()) {
    EXPECT_NEAR(map[id].position_in_world.z(), 2, map[id].at_edge ? 0.001 : 1e-5);
  }
}

Surfel Stored(const Surfel& surfel) {
  SurfelMap map;
  return map[map.Append(surfel)];
}

// Result of one pass for a surfel, over all surfels.
Surfel ByAll(const Surfel& surfel, const std::vector<Surfel>& all, const DepthSensor& sensor) {
  const auto sigma = [&](const Surfel& of) {
    const double z = of.radius_m * sensor.camera.fx / std::sqrt(2);
    return sensor.noise.SigmaZ(z) / std::sqrt(std::max(of.confidence, 1.f));
  };
  const Eigen::Vector3d p = surfel.position_in_world.cast<double>();
  const Eigen::Vector3d n = surfel.normal_in_world.cast<double>();
  const double reach = std::min(3. * surfel.radius_m, 0.03);
  double weights = 0, sum = 0;
  Eigen::Vector3d normals = Eigen::Vector3d::Zero();
  for (const Surfel& other : all) {
    const Eigen::Vector3d way = other.position_in_world.cast<double>() - p;
    const Eigen::Vector3d m = other.normal_in_world.cast<double>();
    if (other.at_edge || way.norm() > reach || n.dot(m) < 0.9) continue;
    const double h = m.dot(way) / m.dot(n), s = 0.001 + sigma(surfel) + sigma(other);
    const double weight = other.confidence * (1 - (1 - n.dot(m)) / 0.1) *
                          std::exp(-2 * way.squaredNorm() / (reach * reach) - h * h / (s * s));
    weights += weight;
    sum += weight * h;
    normals += weight * m;
  }
  Surfel moved = surfel;
  if (!(weights > 0)) return moved;
  moved.position_in_world = (p + sum / weights * n).cast<float>();
  moved.normal_in_world = normals.normalized().cast<float>();
  return Stored(moved);
}

// Includes the borders of cells, which have a size of 0.5 m. Coordinates of 2 m have errors of
// 1.2e-7 m. They change h / s by 1e-4, and weights of normals with angles up to 0.45 rad by 2e-4.
TEST(SmoothMap, AgreesWithTwoBruteForcePasses) {
  const auto wave = [](float x) { return 2 + 0.02f * std::sin(20 * x); };
  SurfelMap map = WallAt(wave, 0.003f, 0.1f);
  std::vector<Surfel> all;
  const std::vector<std::int32_t> ids = map.Ids();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Surfel surfel = map[ids[i]];
    surfel.position_in_world.x() += 0.35f;
    surfel.confidence = 0.5f + static_cast<float>(i % 7);
    surfel.radius_m = 0.004f + 0.002f * static_cast<float>(i % 4);
    surfel.at_edge = i % 11 == 0;
    all.push_back(surfel);
  }
  SurfelMap shifted;
  shifted.Append(all);
  std::vector<Surfel> sorted;
  for (const std::int32_t id : shifted.Ids()) sorted.push_back(shifted[id]);
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<Surfel> before = sorted;
    for (Surfel& surfel : sorted) surfel = ByAll(surfel, before, Sensor());
  }
  SmoothMap(Sensor(), &shifted);
  std::size_t i = 0;
  for (const std::int32_t id : shifted.Ids()) {
    const Surfel surfel = shifted[id];
    // One step of a stored position.
    EXPECT_LT((surfel.position_in_world - sorted[i].position_in_world).norm(),
              1e-5f + 2 * kPositionRounding);
    EXPECT_LT((surfel.normal_in_world - sorted[i].normal_in_world).norm(), 2e-4f);
    ++i;
  }
}

TEST(SmoothMapThreads, AreBitwiseIdentical) {
  const auto wave = [](float x) { return 2 + 0.02f * std::sin(20 * x); };
  SurfelMap one = WallAt(wave, 0.003f, 0.1f), many = one;
  {
    const ThreadLimit limit(1);
    SmoothMap(Sensor(), &one);
  }
  const ThreadLimit limit(4);
  SmoothMap(Sensor(), &many);
  ExpectSameMap(one, many);
}

}  // namespace
}  // namespace surfit::testing
