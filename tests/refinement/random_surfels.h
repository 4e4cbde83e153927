#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "refinement/reduced_system.h"

namespace surfit::testing {

// A few planes before a few cameras, seen with noise: a problem of the kind that refinement solves,
// without images.
struct RandomProblem {
  SharedSurfels shared;
  JointState state;
};

// Each surfel is seen by about 70 % of the poses that are at most so many from one of them; by
// default from all.
inline RandomProblem MakeRandomProblem(int poses, int surfels, double noise_sigmas,
                                       int reach = std::numeric_limits<int>::max()) {
  constexpr float kInverseSigma = 400;  // m
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1, 1);
  RandomProblem problem;
  DepthCalibration& calibration = problem.state.calibration;
  calibration.camera.width = 320;
  calibration.camera.height = 240;
  calibration.camera.fx = 262;
  calibration.camera.fy = 264;
  calibration.camera.cx = 158;
  calibration.camera.cy = 121;
  calibration.field.coefficients = {0.004, -0.002, 0.003, 0.001, 0.002, -0.001};
  for (int k = 0; k < poses; ++k) {
    Rigid3d pose;
    pose.rotation =
        QuaternionExp<double>(0.3 * Eigen::Vector3d(unit(random), unit(random), unit(random)));
    pose.translation = 0.5 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    problem.state.world_from_camera.push_back(pose);
  }
  for (int s = 0; s < surfels; ++s) {
    SharedSurfel surfel;
    surfel.point_in_world = {unit(random), unit(random), 2.5 + unit(random)};
    surfel.normal_in_world =
        Eigen::Vector3d(0.6 * unit(random), 0.6 * unit(random), -1).normalized();
    surfel.begin = problem.shared.observations.size();
    for (int k = 0; k < poses; ++k) {
      if (unit(random) > 0.4 || std::abs(k - s % poses) > reach) continue;
      const Rigid3d& pose = problem.state.world_from_camera[k];
      const Eigen::Vector2d at = calibration.camera.Project(pose.Inverse() * surfel.point_in_world);
      PlaneObservation seen;
      seen.keyframe = k;
      seen.u = static_cast<float>(std::round(at.x()));
      seen.v = static_cast<float>(std::round(at.y()));
      const Eigen::Vector3d ray = calibration.camera.Ray(seen.u, seen.v);
      const double plane_inverse =
          surfel.normal_in_world.dot(pose.rotation * ray) /
          surfel.normal_in_world.dot(surfel.point_in_world - pose.translation);
      seen.inverse_depth =
          static_cast<float>(plane_inverse - calibration.field.At(ray.x(), ray.y()) +
                             noise_sigmas * normal(random) / kInverseSigma);
      seen.inverse_sigma = kInverseSigma;
      problem.shared.observations.push_back(seen);
    }
    surfel.end = problem.shared.observations.size();
    problem.shared.surfels.push_back(surfel);
  }
  return problem;
}

}  // namespace surfit::testing
