// Inertial factors in a Ceres problem: gravity, velocities and biases from poses of a camera.
#include <ceres/ceres.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "cost_functions/inertial_motion.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/sensor_prior.h"
#include "surfit/simulation/camera_path.h"

using Eigen::Vector3d;

// Simulated camera that moves by about 0.3 m and turns by about 0.3 rad. The world has z up.
surfit::SmoothPath Path() {
  surfit::Trajectory poses;
  for (int i = 0; i <= 60; ++i) {
    const double t = i / 30.;
    const Vector3d turn(0.3 * std::sin(2.3 * t), 0.3 * std::sin(1.7 * t), 0.2 * std::sin(2.9 * t));
    poses.push_back(
        {t,
         {surfit::QuaternionExp<double>(turn),
          {0.3 * std::sin(1.9 * t), 0.2 * std::cos(1.3 * t), 0.1 * std::sin(2.4 * t)}}});
  }
  return surfit::SmoothPath(poses);
}

// Ten poses of 2 s are measured to 1 mm and 0.5 mrad. The samples between them determine gravity,
// velocities and biases.
int main() {
  constexpr int kPoses = 10;
  constexpr double kInterval_s = 0.2, kSigma_m = 0.001, kSigma_rad = 0.0005;
  const surfit::SmoothPath path = Path();
  const surfit::ImuSimulation sensor;
  const std::vector<surfit::ImuSample> samples = surfit::SimulateImu(path, sensor);

  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  surfit::PoseInformation information = surfit::PoseInformation::Zero();
  std::array<std::array<double, surfit::kPoseSize>, kPoses> poses;
  std::array<std::array<double, surfit::kMotionSize>, kPoses> motions = {};
  // The start errs by 30 degrees.
  constexpr double kSize = surfit::kGravity_m_per_s2;
  std::array<double, 3> gravity = {0, -0.5 * kSize, -std::sqrt(0.75) * kSize};
  ceres::Problem problem;
  for (int i = 0; i < kPoses; ++i) {
    surfit::Rigid3d measured = path.At(i * kInterval_s);
    Vector3d turn;
    for (int k = 0; k < 3; ++k) {
      turn[k] = kSigma_rad * normal(random);
      measured.translation[k] += kSigma_m * normal(random);
      information(k, k) = 1 / (kSigma_rad * kSigma_rad);
      information(k + 3, k + 3) = 1 / (kSigma_m * kSigma_m);
    }
    measured.rotation = measured.rotation * surfit::QuaternionExp<double>(turn);
    surfit::PoseToBlock(measured, poses[i].data());
    problem.AddParameterBlock(poses[i].data(), surfit::kPoseSize, new surfit::ProductPoseManifold);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<surfit::SensorPrior, 6, surfit::kPoseSize>(
            new surfit::SensorPrior(surfit::Rigid3d(), measured, information)),
        nullptr, poses[i].data());
  }
  for (int i = 0; i + 1 < kPoses; ++i) {
    const auto motion = surfit::PreintegrateImu(samples, i * kInterval_s, (i + 1) * kInterval_s,
                                                surfit::ImuBias(), sensor.calibration.noise);
    if (!motion) return 1;
    problem.AddResidualBlock(new surfit::AnalyticInertialMotion(*motion), nullptr, poses[i].data(),
                             motions[i].data(), poses[i + 1].data(), motions[i + 1].data(),
                             gravity.data());
  }
  // The length of gravity is known, and its direction is free. In two seconds, a bias of the
  // accelerometer and a tilt of gravity are nearly the same.
  problem.SetManifold(gravity.data(), new ceres::SphereManifold<3>);

  ceres::Solver::Summary summary;
  ceres::Solve(ceres::Solver::Options(), &problem, &summary);
  const double angle = std::acos(-gravity[2] / Vector3d(gravity.data()).norm());
  const Vector3d speed_error =
      Vector3d(motions[5].data()) - path.MotionAt(5 * kInterval_s).velocity_m_per_s;
  std::printf("gravity to %.2f degrees, velocity to %.1f mm/s\n", angle / surfit::kRadPerDeg,
              1e3 * speed_error.norm());
  return angle < surfit::kRadPerDeg && speed_error.norm() < 0.02 ? 0 : 1;
}
