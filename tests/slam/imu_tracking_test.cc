#include "tracking/inertial/imu_tracking.h"

#include <gmock/gmock.h>

#include <limits>

#include "slam/imu_path.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kImuPoseSigma_rad = 0.001, kImuPoseSigma_m = 0.002, kEvery_s = 1. / 30;

ImuRecording RecordingOf(const SmoothPath& path, int seed, bool rotation_is_given = true) {
  ImuSimulation simulation;
  simulation.seed = seed;
  simulation.calibration.camera_from_imu = ImuMount();
  ImuRecording recording;
  recording.samples = SimulateImu(path, simulation);
  recording.read_from = "simulation";
  recording.calibration = simulation.calibration;
  recording.calibration.rotation_sigma_rad =
      rotation_is_given ? 0.005 : std::numeric_limits<double>::infinity();
  return recording;
}

TrackedPose TrackedAt(const SmoothPath& path, int frame, std::mt19937_64* rng) {
  const RegisteredPose noisy =
      NoisyPose(path, frame * kEvery_s, kImuPoseSigma_rad, kImuPoseSigma_m, rng);
  TrackedPose pose;
  pose.frame = frame;
  pose.stamp_s = noisy.stamp_s;
  pose.world_from_camera = pose.registered = noisy.world_from_camera;
  pose.information.diagonal() = noisy.covariance.diagonal().cwiseInverse();
  pose.continues = frame > 0;
  return pose;
}

// Tracks the frames [begin, end) of a path.
void Track(const SmoothPath& path, int begin, int end, std::mt19937_64* rng, ImuTracking* imu) {
  for (int i = begin; i < end; ++i) {
    const auto predicted = imu->Predict(i * kEvery_s);
    imu->Add(TrackedAt(path, i, rng), predicted);
  }
}

TEST(ImuTracking, PredictsByGyroscopeAndThenByBoth) {
  const SmoothPath path = SwungCamera(4);
  ImuTracking imu(RecordingOf(path, 1));
  std::mt19937_64 rng(1);
  EXPECT_FALSE(imu.Predict(0));
  Track(path, 0, 5, &rng, &imu);
  const auto early = imu.Predict(5 * kEvery_s);
  ASSERT_TRUE(early);
  EXPECT_FALSE(early->covariance);
  const Rigid3d error = early->world_from_camera.Inverse() * path.At(5 * kEvery_s);
  EXPECT_LT(RotationAngle(error.rotation), 5 * kImuPoseSigma_rad + 0.01 * kEvery_s * 4);
  Track(path, 5, 60, &rng, &imu);
  const auto late = imu.Predict(2.5);
  ASSERT_TRUE(late && late->covariance);
  EXPECT_LT((late->world_from_camera.Inverse() * path.At(2.5)).translation.norm(), 0.06);
  EXPECT_FALSE(imu.Predict(3.2));  // more than 1.1 s after the last pose
  const ImuReport report = imu.report();
  EXPECT_EQ(report.off_reason, "");
  EXPECT_EQ(report.starts, 1);
  EXPECT_GT(report.gyro_frames, 3);
  EXPECT_EQ(report.gyro_frames + report.full_frames, 59);
  ASSERT_TRUE(report.up_in_world);
  EXPECT_LT(std::acos(report.up_in_world->z()), 4 * report.up_sigma_rad);
}

TEST(ImuTracking, BridgesGapAndReportsIt) {
  const SmoothPath path = SwungCamera(5);
  ImuTracking imu(RecordingOf(path, 2));
  std::mt19937_64 rng(2);
  Track(path, 0, 70, &rng, &imu);
  EXPECT_THAT(imu.report().bridges, IsEmpty());
  Track(path, 85, 100, &rng, &imu);
  const ImuReport report = imu.report();
  ASSERT_EQ(report.bridges.size(), 1u);
  const ImuBridge& bridge = report.bridges[0];
  EXPECT_EQ(bridge.frame, 85);
  EXPECT_NEAR(bridge.seconds, 16 * kEvery_s, 1e-9);
  EXPECT_LT(bridge.correction_m, 0.05);
  EXPECT_LT(bridge.correction_m, 4 * std::hypot(bridge.sigma_m, kImuPoseSigma_m));
  EXPECT_EQ(report.starts, 1);
  EXPECT_EQ(report.off_reason, "");
}

TEST(ImuTracking, FindsUnknownRotationFromMotion) {
  const SmoothPath path = SwungCamera(6);
  ImuTracking imu(RecordingOf(path, 3, false));
  std::mt19937_64 rng(3);
  Track(path, 0, 20, &rng, &imu);
  EXPECT_FALSE(imu.IsActive());
  EXPECT_FALSE(imu.Predict(20 * kEvery_s));
  Track(path, 20, 170, &rng, &imu);
  EXPECT_TRUE(imu.IsActive());
  const ImuReport report = imu.report();
  EXPECT_TRUE(report.rotation_is_known);
  EXPECT_LT(
      RotationAngle(report.calibration.camera_from_imu.rotation.conjugate() * ImuMount().rotation),
      0.3 * kRadPerDeg);
  EXPECT_GT(report.full_frames, 0);
}

// The pose with the prior contains samples that the filter has already used.
TEST(ImuTracking, UsesRegisteredPoseWithoutPrior) {
  const SmoothPath path = SwungCamera(4);
  ImuTracking imu(RecordingOf(path, 4)), other(RecordingOf(path, 4));
  std::mt19937_64 rng(4);
  for (int i = 0; i < 80; ++i) {
    TrackedPose pose = TrackedAt(path, i, &rng);
    const auto predicted = imu.Predict(pose.stamp_s), same = other.Predict(pose.stamp_s);
    if (predicted && predicted->covariance) {
      ASSERT_TRUE(same && same->covariance);
      EXPECT_EQ(predicted->world_from_camera, same->world_from_camera);
    }
    imu.Add(pose, predicted);
    pose.world_from_camera.translation.x() += 0.1;
    other.Add(pose, same);
  }
  EXPECT_GT(imu.report().full_frames, 30);
}

TEST(ImuTracking, IsSwitchedOffIfItContradictsPoses) {
  const SmoothPath path = SwungCamera(4), moved = SwungCamera(4, -2);
  ImuTracking imu(RecordingOf(moved, 5));
  std::mt19937_64 rng(5);
  Track(path, 0, 100, &rng, &imu);
  EXPECT_NE(imu.report().off_reason, "");
  EXPECT_FALSE(imu.IsActive());
  EXPECT_FALSE(imu.Predict(100 * kEvery_s));
}

// The state of the filter is wrong after a step of the map. The sensor is right.
TEST(ImuTracking, StartsAgainAfterStepOfTheMap) {
  const SmoothPath path = SwungCamera(10);
  ImuTracking imu(RecordingOf(path, 9));
  std::mt19937_64 rng(9);
  Track(path, 0, 200, &rng, &imu);
  ASSERT_EQ(imu.report().starts, 1);
  const Rigid3d step(Eigen::Quaterniond::Identity(), {0.8, 0, 0});
  for (int i = 200; i < 260; ++i) {
    TrackedPose pose = TrackedAt(path, i, &rng);
    pose.world_from_camera = pose.registered = step * pose.registered;
    imu.Add(pose, imu.Predict(pose.stamp_s));
  }
  EXPECT_EQ(imu.report().off_reason, "");
  EXPECT_EQ(imu.report().starts, 2);
  const auto predicted = imu.Predict(260 * kEvery_s);
  ASSERT_TRUE(predicted && predicted->covariance);
  const Rigid3d truth = step * TrackedAt(path, 260, &rng).registered;
  EXPECT_LT((predicted->world_from_camera.translation - truth.translation).norm(), 0.02);
}

TEST(ImuTracking, FindsGravityWithoutGyroscope) {
  const SmoothPath path = SwungCamera(4);
  ImuRecording recording = RecordingOf(path, 6);
  recording.has_gyro = false;
  for (ImuSample& sample : recording.samples) sample.gyro_rad_per_s.setZero();
  ImuTracking imu(std::move(recording));
  std::mt19937_64 rng(6);
  Track(path, 0, 100, &rng, &imu);
  EXPECT_FALSE(imu.IsActive());
  const ImuReport report = imu.report();
  EXPECT_EQ(report.off_reason, "");
  EXPECT_EQ(report.gyro_frames, 0);
  ASSERT_TRUE(report.up_in_world);
  EXPECT_LT(std::acos(report.up_in_world->z()), 3 * report.up_sigma_rad);
}

TEST(ImuTracking, RejectsAccelerometerInG) {
  ImuRecording recording = RecordingOf(SwungCamera(1), 6);
  for (ImuSample& sample : recording.samples) sample.accel_m_per_s2 /= kGravity_m_per_s2;
  EXPECT_THAT(ImuTracking(std::move(recording)).report().off_reason, HasSubstr("its unit is g"));
}

TEST(ImuTracking, FindsWrongSignOfAccelerometer) {
  const SmoothPath path = SwungCamera(5);
  ImuRecording recording = RecordingOf(path, 8);
  for (ImuSample& sample : recording.samples) sample.accel_m_per_s2 *= -1;
  ImuTracking imu(std::move(recording));
  std::mt19937_64 rng(8);
  Track(path, 0, 140, &rng, &imu);
  EXPECT_THAT(imu.report().off_reason, HasSubstr("the sign of the accelerometer is wrong"));
}

TEST(ImuTracking, StartsAgainAfterPoseFromSearch) {
  const SmoothPath path = SwungCamera(5);
  ImuTracking imu(RecordingOf(path, 7));
  std::mt19937_64 rng(7);
  Track(path, 0, 50, &rng, &imu);
  TrackedPose found = TrackedAt(path, 50, &rng);
  found.continues = false;
  imu.Add(found, imu.Predict(found.stamp_s));
  ASSERT_TRUE(imu.Predict(51 * kEvery_s));
  EXPECT_FALSE(imu.Predict(51 * kEvery_s)->covariance);
  Track(path, 51, 80, &rng, &imu);
  EXPECT_TRUE(imu.Predict(80 * kEvery_s)->covariance);
  EXPECT_EQ(imu.report().starts, 2);
}

}  // namespace
}  // namespace surfit::testing
