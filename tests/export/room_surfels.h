#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit::testing {

// Appends surfels of a rectangle with noise along its normal, every 2 cm.
inline void AddRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& side,
                         const Eigen::Vector3d& other, double noise_m, std::mt19937_64* rng,
                         std::vector<Surfel>* surfels) {
  constexpr double kStep_m = 0.02;
  std::normal_distribution<double> noise(0, noise_m);
  const Eigen::Vector3d normal = side.cross(other).normalized();
  for (double a = 0; a < side.norm(); a += kStep_m) {
    for (double b = 0; b < other.norm(); b += kStep_m) {
      Surfel surfel;
      surfel.position_in_world =
          (corner + a * side.normalized() + b * other.normalized() + noise(*rng) * normal)
              .cast<float>();
      surfel.normal_in_world = normal.cast<float>();
      surfel.radius_m = 0.015f;
      surfel.confidence = 20;
      surfels->push_back(surfel);
    }
  }
}

// Floor at z = 0 and four walls of a room of 4 x 3 x 2.5 m, and a table of 1.2 x 0.7 m. Normals are
// inward. The table is not level by 1 degree.
inline std::vector<Surfel> RoomSurfels(double noise_m, std::mt19937_64* rng) {
  std::vector<Surfel> surfels;
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  AddRectangle({0, 0, 0}, 4 * x, 3 * y, noise_m, rng, &surfels);
  AddRectangle({0, 0, 0}, 3 * y, 2.5 * z, noise_m, rng, &surfels);
  AddRectangle({4, 0, 0}, 2.5 * z, 3 * y, noise_m, rng, &surfels);
  AddRectangle({0, 0, 0}, 2.5 * z, 4 * x, noise_m, rng, &surfels);
  AddRectangle({0, 3, 0}, 4 * x, 2.5 * z, noise_m, rng, &surfels);
  AddRectangle({1.4, 1, 0.7}, 1.2 * Eigen::Vector3d(1, 0, 0.0175), 0.7 * y, noise_m, rng, &surfels);
  return surfels;
}

// Cameras at 1.4 m that turn by 360 degrees and look down by 20 degrees.
inline Trajectory RoomCameras() {
  Trajectory cameras;
  for (int i = 0; i < 36; ++i) {
    const double turn = i * 10 * kRadPerDeg, down = 20 * kRadPerDeg;
    const Eigen::Vector3d forward(std::cos(turn) * std::cos(down), std::sin(turn) * std::cos(down),
                                  -std::sin(down));
    const Eigen::Vector3d right(std::sin(turn), -std::cos(turn), 0);
    Eigen::Matrix3d rotation;
    rotation << right, forward.cross(right), forward;
    cameras.push_back({0.1 * i, Rigid3d(rotation, {2 + 0.5 * std::cos(turn), 1.5, 1.4})});
  }
  return cameras;
}

inline void Move(const Rigid3d& world_from_room, std::vector<Surfel>* surfels,
                 Trajectory* cameras) {
  for (Surfel& surfel : *surfels) {
    surfel.position_in_world =
        (world_from_room * surfel.position_in_world.cast<double>()).cast<float>();
    surfel.normal_in_world = world_from_room.rotation.cast<float>() * surfel.normal_in_world;
  }
  for (StampedPose& pose : *cameras) {
    pose.world_from_camera = world_from_room * pose.world_from_camera;
  }
}

}  // namespace surfit::testing
