#include "tracking/inertial/imu_smoother.h"

#include <gmock/gmock.h>

#include "slam/imu_path.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr double kTurnNoise_rad = 0.003, kPlaceNoise_m = 0.008;

// Poses of a swung camera with registration noise, and the samples of its inertial sensor.
struct NoisyRegistrations {
  SmoothPath path;
  ImuSimulation simulation;
  std::vector<ImuSample> samples;
  std::vector<PoseToSmooth> poses;

  explicit NoisyRegistrations(int frames, int seed = 1) : path(SwungCamera(frames / 30. + 0.1)) {
    simulation.seed = seed;
    simulation.calibration.camera_from_imu = ImuMount();
    simulation.calibration.time_offset_s = 0.02;
    samples = SimulateImu(path, simulation);
    std::mt19937_64 rng(seed);
    for (int i = 0; i < frames; ++i) {
      const RegisteredPose noisy = NoisyPose(path, i / 30., kTurnNoise_rad, kPlaceNoise_m, &rng);
      poses.push_back({noisy.stamp_s, noisy.world_from_camera, noisy.world_from_camera,
                       noisy.covariance, i > 0});
    }
  }
  std::vector<Rigid3d> Smoothed() const {
    return SmoothByImu(samples, simulation.calibration, poses).world_from_camera;
  }
  double ErrorAt(int i, const Rigid3d& pose) const {
    return (pose.translation - path.At(poses[i].stamp_s).translation).norm();
  }
  // RMS position errors of frames [begin, end), m.
  double Rms(const std::vector<Rigid3d>& world_from_camera, int begin, int end) const {
    double sum = 0;
    for (int i = begin; i < end; ++i) sum += std::pow(ErrorAt(i, world_from_camera[i]), 2);
    return std::sqrt(sum / (end - begin));
  }
  std::vector<Rigid3d> Given() const {
    std::vector<Rigid3d> given;
    for (const PoseToSmooth& pose : poses) given.push_back(pose.world_from_camera);
    return given;
  }
};

TEST(SmoothByImu, DividesErrorsOfRegistrationByThree) {
  for (const int seed : {1, 2, 3}) {
    const NoisyRegistrations noisy(120, seed);
    const std::vector<Rigid3d> smoothed = noisy.Smoothed();
    ASSERT_EQ(smoothed.size(), 120u);
    EXPECT_LT(noisy.Rms(smoothed, 0, 120), noisy.Rms(noisy.Given(), 0, 120) / 3) << seed;
    double turn_rad = 0;
    for (int i = 0; i < 120; ++i)
      turn_rad += RotationAngle((noisy.path.At(i / 30.).Inverse() * smoothed[i]).rotation) / 120;
    EXPECT_LT(turn_rad, kTurnNoise_rad / 3) << seed;
  }
}

TEST(SmoothByImu, HasNoStepsBetweenChunks) {
  const NoisyRegistrations noisy(600);
  const std::vector<Rigid3d> smoothed = noisy.Smoothed();
  EXPECT_LT(noisy.Rms(smoothed, 445, 455), kPlaceNoise_m / 2);
  const auto motion = [](const Rigid3d& a, const Rigid3d& b) {
    return Eigen::Vector3d(b.translation - a.translation);
  };
  const Eigen::Vector3d step =
      motion(smoothed[449], smoothed[450]) -
      motion(noisy.path.At(noisy.poses[449].stamp_s), noisy.path.At(noisy.poses[450].stamp_s));
  EXPECT_LT(step.norm(), 0.002);
}

// RMS error of the rotations over one second, rad.
double TurnError(const NoisyRegistrations& noisy, const std::vector<Rigid3d>& poses) {
  double sum = 0;
  const int count = static_cast<int>(poses.size()) - 30;
  for (int i = 0; i < count; ++i) {
    const Rigid3d exact = noisy.path.At(i / 30.).Inverse() * noisy.path.At(i / 30. + 1);
    const Rigid3d turn = exact.Inverse() * poses[i].Inverse() * poses[i + 30];
    sum += std::pow(RotationAngle(turn.rotation), 2) / count;
  }
  return std::sqrt(sum);
}

TEST(SmoothByImu, ReducesTheTurnOfADriftingMapByAThird) {
  for (const int seed : {1, 2, 3}) {
    NoisyRegistrations noisy(300, seed);
    std::mt19937_64 rng(seed);
    DriftingMap map(noisy.path, &rng);
    for (PoseToSmooth& pose : noisy.poses) {
      pose.world_from_camera =
          NoisyPose(map.At(pose.stamp_s), pose.stamp_s, 0.0005, 0.001, &rng).world_from_camera;
      pose.registered = pose.world_from_camera;
      pose.covariance = NoisyPose(Rigid3d(), 0, 0.0005, 0.001, &rng).covariance;
    }
    EXPECT_LT(TurnError(noisy, noisy.Smoothed()), TurnError(noisy, noisy.Given()) * 2 / 3) << seed;
  }
}

TEST(SmoothByImu, OutlierOfRegistrationMovesItsFrameLittle) {
  NoisyRegistrations noisy(120);
  noisy.poses[60].registered->translation.x() += 0.2;
  noisy.poses[60].world_from_camera = *noisy.poses[60].registered;
  EXPECT_LT(noisy.ErrorAt(60, noisy.Smoothed()[60]), 0.02);
}

TEST(SmoothByImu, InertialSensorPlacesFramesWithoutRegistration) {
  NoisyRegistrations noisy(120);
  for (int i = 60; i < 70; ++i) {
    noisy.poses[i].registered.reset();
    noisy.poses[i].world_from_camera = noisy.poses[59].world_from_camera;
  }
  const std::vector<Rigid3d> smoothed = noisy.Smoothed();
  EXPECT_GT(noisy.Rms(noisy.Given(), 60, 70), 0.05);
  EXPECT_LT(noisy.Rms(smoothed, 60, 70), 0.01);
}

TEST(SmoothByImu, ChangesNoChainThatIsTooShortOrWithoutSamples) {
  NoisyRegistrations noisy(40);
  for (int i = 0; i < 40; i += 10) noisy.poses[i].continues = false;
  EXPECT_EQ(noisy.Smoothed(), noisy.Given());
  noisy = NoisyRegistrations(40);
  noisy.samples.clear();
  EXPECT_EQ(noisy.Smoothed(), noisy.Given());
}

// The direction is limited by the bias of the accelerometer: its prior is 0.1 m/s^2.
TEST(SmoothByImu, FindsUp) {
  for (const int seed : {1, 2, 3}) {
    const NoisyRegistrations noisy(300, seed);
    const auto up =
        SmoothByImu(noisy.samples, noisy.simulation.calibration, noisy.poses).up_in_world;
    ASSERT_TRUE(up);
    EXPECT_LT(std::acos(up->z()), 0.01) << seed;
  }
}

TEST(SmoothByImu, IsBitwiseReproducible) {
  const NoisyRegistrations noisy(60);
  EXPECT_EQ(noisy.Smoothed(), noisy.Smoothed());
}

}  // namespace
}  // namespace surfit::testing
