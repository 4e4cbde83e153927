#pragma once

#include <optional>
#include <vector>

#include "surfit/geometry/inertial.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Longest time between two poses that inertial sensors connect, s.
inline constexpr double kMaxImuBridge_s = 1.1;

// Pose of a frame, and the registration that determines it.
struct PoseToSmooth {
  double stamp_s = 0;  // capture time
  Rigid3d world_from_camera;
  // Registered pose without any inertial information. std::nullopt: not registered.
  std::optional<Rigid3d> registered;
  // Covariance (rad, m) of `registered`: left perturbation of the identity in the camera frame.
  Matrix6d covariance = Matrix6d::Zero();
  // False: the inertial sensor does not connect this pose with the previous one.
  bool continues = false;
};

struct SmoothedPoses {
  std::vector<Rigid3d> world_from_camera;
  // Unit vector opposite to gravity in the world, of the longest chain. std::nullopt: no solution.
  std::optional<Eigen::Vector3d> up_in_world;
};

// Returns the poses of all frames that fit both the registered poses and the
// inertial measurements between them best. Ceres minimises the sum of
// - AnalyticRelativePose, with a Huber kernel, from the map to each registered pose
// - AnalyticRelativePose between consecutive poses of the map, see MapDrift(), and SensorPrior that
//   keeps the map in its place over more than 10 s
// - AnalyticInertialMotion for consecutive poses, with velocity and biases at each pose
// - priors of the biases
// The map is one rigid body that drifts slowly. The direction of gravity is free, its length is
// fixed. Poses are solved in overlapping chunks of 450 frames; each continues the one before. A
// chunk without a solution keeps its poses. A chain of less than 5 poses or 0.4 s keeps its poses,
// too. Runs on one thread: the result is bitwise reproducible.
SmoothedPoses SmoothByImu(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                          const std::vector<PoseToSmooth>& poses);

}  // namespace surfit
