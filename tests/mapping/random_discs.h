#pragma once

#include <Eigen/Core>
#include <random>

#include "mapping/random_surfel.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

inline PinholeCamera SmallCamera() { return {64, 48, 60, 61, 30.5, 24.25, {}}; }

// The surfel of a disc given in the camera's frame.
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

// Discs in, beside and behind the view, some of them turned away, half of them unstable.
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

}  // namespace surfit::testing
