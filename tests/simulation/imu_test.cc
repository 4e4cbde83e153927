// Tests of the simulated inertial sensor.
#include <gmock/gmock.h>

#include <cmath>

#include "surfit/core/error.h"
#include "surfit/simulation/camera_path.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

// Hand-held motion at 30 poses per second.
SmoothPath SwungPath() {
  Trajectory poses;
  for (int i = 0; i <= 60; ++i) {
    const double t = i / 30.;
    const Vector3d turn(0.4 * std::sin(3 * t), 0.5 * std::cos(2 * t), 0.3 * std::sin(4 * t + 1));
    const Vector3d place(0.2 * std::sin(4 * t), 0.1 * std::cos(3 * t), 0.15 * std::sin(2 * t));
    poses.push_back({t, {QuaternionExp<double>(turn), place}});
  }
  return SmoothPath(poses);
}

Rigid3d Mount() { return {QuaternionExp<double>(Vector3d(0.3, -2, 1)), {0.03, -0.02, 0.05}}; }

TEST(SmoothPath, DerivativesAgreeWithDifferences) {
  const SmoothPath path = SwungPath();
  constexpr double kStep = 1e-5;
  for (double t = 0.313; t < 1.7; t += 0.1) {
    const PathMotion motion = path.MotionAt(t);
    const PathMotion before = path.MotionAt(t - kStep), after = path.MotionAt(t + kStep);
    const Rigid3d moved = path.At(t - kStep).Inverse() * path.At(t + kStep);
    const auto difference = [&](const Vector3d& a, const Vector3d& b) -> Vector3d {
      return (b - a) / (2 * kStep);
    };
    const Vector3d shift =
        difference(path.At(t - kStep).translation, path.At(t + kStep).translation);
    EXPECT_LT((shift - motion.velocity_m_per_s).norm(), 1e-8);
    EXPECT_LT((QuaternionLog<double>(moved.rotation) / (2 * kStep) - motion.rate_rad_per_s).norm(),
              1e-8);
    EXPECT_LT(
        (difference(before.velocity_m_per_s, after.velocity_m_per_s) - motion.acceleration_m_per_s2)
            .norm(),
        1e-7);
    EXPECT_LT(
        (difference(before.rate_rad_per_s, after.rate_rad_per_s) - motion.rate_change_rad_per_s2)
            .norm(),
        1e-7);
  }
}

TEST(SimulateImu, MeasuresGravityAtRest) {
  const Rigid3d pose(QuaternionExp<double>(Vector3d(1, 0.2, -0.3)), {1, 2, 3});
  ImuSimulation simulation;
  simulation.has_errors = false;
  simulation.calibration.camera_from_imu = Mount();
  simulation.calibration.time_offset_s = 0.5;
  const auto samples = SimulateImu(SmoothPath({{1, pose}, {2, pose}}), simulation);
  ASSERT_EQ(samples.size(), 201u);
  EXPECT_EQ(samples.front().stamp_s, 1.5);
  for (const ImuSample& sample : samples) {
    EXPECT_LT(sample.gyro_rad_per_s.norm(), 1e-12);
    const Vector3d in_world = pose.rotation * (Mount().rotation * sample.accel_m_per_s2);
    EXPECT_LT((in_world - Vector3d(0, 0, kGravity_m_per_s2)).norm(), 1e-12);
  }
}

// Integration of exact measurements gives the path of the sensor.
TEST(SimulateImu, IntegratesToPath) {
  const SmoothPath path = SwungPath();
  ImuSimulation simulation;
  simulation.rate_hz = 1000;
  simulation.has_errors = false;
  simulation.calibration.camera_from_imu = Mount();
  const auto samples = SimulateImu(path, simulation);
  const auto state_at = [&](double t) {
    const PathMotion motion = path.MotionAt(t);
    const Rigid3d camera = path.At(t);
    const Vector3d speed = motion.velocity_m_per_s +
                           camera.rotation * motion.rate_rad_per_s.cross(Mount().translation);
    return ImuState{camera * Mount(), speed};
  };
  const auto motion = PreintegrateImu(samples, 0.5, 1.5, {}, {});
  ASSERT_TRUE(motion);
  const ImuState end = PredictImu(state_at(0.5), *motion, {0, 0, -kGravity_m_per_s2});
  const ImuState truth = state_at(1.5);
  const Rigid3d error = truth.world_from_imu.Inverse() * end.world_from_imu;
  // The midpoint rule errs by about (rate step)^2 / 12 of the motion: 1e-6.
  EXPECT_LT(error.translation.norm(), 1e-5);
  EXPECT_LT(RotationAngle(error.rotation), 1e-5);
  EXPECT_LT((end.velocity_m_per_s - truth.velocity_m_per_s).norm(), 1e-5);
}

TEST(SimulateImu, ErrorsHaveGivenDensities) {
  const Rigid3d pose;
  ImuSimulation simulation;
  simulation.seed = 5;
  const SmoothPath path({{0, pose}, {100, pose}});
  const auto noisy = SimulateImu(path, simulation);
  EXPECT_EQ(noisy.size(), SimulateImu(path, simulation).size());
  EXPECT_EQ(noisy.back().gyro_rad_per_s, SimulateImu(path, simulation).back().gyro_rad_per_s);
  double gyro = 0, accel = 0;
  for (std::size_t i = 1; i < noisy.size(); ++i) {
    gyro += (noisy[i].gyro_rad_per_s - noisy[i - 1].gyro_rad_per_s).squaredNorm() / 6;
    accel += (noisy[i].accel_m_per_s2 - noisy[i - 1].accel_m_per_s2).squaredNorm() / 6;
  }
  const ImuNoise& noise = simulation.calibration.noise;
  const double count = static_cast<double>(noisy.size());
  EXPECT_NEAR(std::sqrt(gyro / count / 200) / noise.gyro_density, 1, 0.02);
  EXPECT_NEAR(std::sqrt(accel / count / 200) / noise.accel_density, 1, 0.02);
}

TEST(SimulateImu, RejectsInvalidRateAndNoise) {
  const SmoothPath path = SwungPath();
  ImuSimulation simulation;
  simulation.rate_hz = 0;
  EXPECT_THROW(SimulateImu(path, simulation), InputError);
  simulation.rate_hz = 100;
  simulation.calibration.noise.accel_density = -1;
  EXPECT_THROW(SimulateImu(path, simulation), InputError);
}

}  // namespace
}  // namespace surfit::testing
