#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "cost_functions/surfel_texture.h"
#include "optimization/refinement/reduced_system.h"

namespace surfit::testing {

// Refinement problem of a few planes and cameras with noise, without images.
struct RandomProblem {
  SharedSurfels shared;
  JointState state;
};

// Adds texture observations to all keyframes of the surfel except the first keyframe. Intensities
// change by about one sigma per px. Taps are a few tenths of a pixel from the projected points.
inline void AddTexture(double noise_sigmas, std::mt19937_64* random, SharedSurfel* surfel,
                       RandomProblem* problem) {
  constexpr float kInverseSigma = 5;
  std::normal_distribution<double> normal;
  SharedSurfels& shared = problem->shared;
  surfel->texture_radius_m = 0.03;
  surfel->textures_begin = surfel->textures_end = shared.textures.size();
  if (surfel->end - surfel->begin < 3) return;
  for (std::size_t i = surfel->begin + 1; i < surfel->end; ++i) {
    TextureObservation seen;
    seen.keyframe = shared.observations[i].keyframe;
    seen.index = static_cast<int>(i - surfel->begin);
    seen.inverse_sigma = kInverseSigma;
    const Rigid3d camera_from_world = problem->state.world_from_camera[seen.keyframe].Inverse();
    const auto points = TexturePoints(*surfel);
    for (std::size_t j = 0; j < points.size(); ++j) {
      const Eigen::Vector2d at =
          problem->state.calibration.camera.Project(camera_from_world * points[j]);
      const Eigen::Vector2d beside = 0.3 * Eigen::Vector2d(normal(*random), normal(*random));
      const Eigen::Vector2d slope =
          Eigen::Vector2d(normal(*random), normal(*random)) / kInverseSigma;
      const double there =
          0.1 * static_cast<double>(j * j) + noise_sigmas * normal(*random) / kInverseSigma;
      IntensityTap& tap = seen.taps[j];
      tap.u = static_cast<float>(at.x() + beside.x());
      tap.v = static_cast<float>(at.y() + beside.y());
      tap.slope_u = static_cast<float>(slope.x());
      tap.slope_v = static_cast<float>(slope.y());
      tap.value = static_cast<float>(there + slope.dot(beside));
    }
    shared.textures.push_back(seen);
  }
  surfel->textures_end = shared.textures.size();
}

// About 70 % of the poses observe a surfel, if their index is within `reach` of one pose. Default:
// all poses.
inline RandomProblem MakeRandomProblem(int poses, int surfels, double noise_sigmas,
                                       int reach = std::numeric_limits<int>::max()) {
  constexpr float kInverseSigma = 400;  // m
  constexpr double kReadout_s = 0.02;
  std::mt19937_64 random(5), motions(6);
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
  calibration.readout_s = kReadout_s;
  calibration.field.coefficients = {0.004, -0.002, 0.003, 0.001, 0.002, -0.001};
  for (int k = 0; k < poses; ++k) {
    Rigid3d pose;
    pose.rotation =
        QuaternionExp<double>(0.3 * Eigen::Vector3d(unit(random), unit(random), unit(random)));
    pose.translation = 0.5 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    problem.state.world_from_camera.push_back(pose);
    const CameraMotion motion = {{unit(motions), unit(motions), unit(motions)},
                                 {unit(motions), unit(motions), unit(motions)}};
    problem.shared.readouts.push_back({motion, kReadout_s});
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
    if (s % 2 == 0) AddTexture(noise_sigmas, &random, &surfel, &problem);
    problem.shared.surfels.push_back(surfel);
  }
  return problem;
}

// Full reduced Hessian: poses, then calibration.
inline Eigen::MatrixXd DenseHessian(const ReducedSystem& system) {
  const BlockPattern& pattern = *system.pattern;
  const Eigen::Index size = system.gradient.size();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  lower.bottomRightCorner<kCalibrationSize, kCalibrationSize>() = system.calibration;
  for (int row = 0; row < pattern.pose_count(); ++row) {
    const int begin = kPoseTangentSize * row;
    lower.block<kCalibrationSize, kPoseTangentSize>(system.CalibrationBegin(), begin) =
        system.mixed[row];
    for (int column = 0; column <= row; ++column) {
      const auto block = pattern.IndexOf(row, column);
      if (block == BlockPattern::kNoBlock) continue;
      lower.block<kPoseTangentSize, kPoseTangentSize>(begin, kPoseTangentSize * column) =
          system.poses[block];
    }
  }
  return lower.selfadjointView<Eigen::Lower>();
}

}  // namespace surfit::testing
