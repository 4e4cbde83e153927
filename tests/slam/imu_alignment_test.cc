#include "tracking/inertial/imu_alignment.h"

#include <gmock/gmock.h>

#include <limits>

#include "slam/imu_path.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kOffset_s = 0.023;

// Turns of a camera over 0.2 s with rotation errors, and the samples of its inertial sensor.
struct Recorded {
  std::vector<ImuSample> samples;
  std::vector<CameraTurn> turns;
  ImuCalibration unknown;
  ImuBias bias;  // of the first sample

  explicit Recorded(int seed, double size = 1, double sigma_rad = 0.002) {
    const SmoothPath path = SwungCamera(6, size);
    ImuSimulation simulation;
    simulation.seed = seed;
    simulation.calibration.camera_from_imu = ImuMount();
    simulation.calibration.time_offset_s = kOffset_s;
    samples = SimulateImu(path, simulation);
    // Without white noise and random walk, the difference is the bias.
    simulation.calibration.noise.gyro_density = simulation.calibration.noise.gyro_bias_density =
        1e-12;
    const ImuSample biased = SimulateImu(path, simulation)[0];
    simulation.has_errors = false;
    bias.gyro_rad_per_s = biased.gyro_rad_per_s - SimulateImu(path, simulation)[0].gyro_rad_per_s;
    std::mt19937_64 rng(seed);
    std::vector<RegisteredPose> poses;
    for (int i = 0; i <= 58; ++i) poses.push_back(NoisyPose(path, 0.1 * i, sigma_rad, 0.003, &rng));
    for (std::size_t i = 2; i < poses.size(); ++i) {
      turns.push_back({poses[i - 2].stamp_s, poses[i].stamp_s,
                       poses[i - 2].world_from_camera.rotation.conjugate() *
                           poses[i].world_from_camera.rotation});
    }
    unknown.rotation_sigma_rad = std::numeric_limits<double>::infinity();
    unknown.time_offset_sigma_s = 0.03;
  }

  ImuAlignment Align() const { return AlignImu(GyroIntegral(&samples), turns, unknown); }
};

TEST(AlignImu, FindsRotationOffsetAndBias) {
  for (int seed = 1; seed <= 10; ++seed) {
    const Recorded recorded(seed);
    const ImuAlignment found = recorded.Align();
    EXPECT_EQ(found.fault, "");
    EXPECT_TRUE(found.is_known);
    const double angle =
        RotationAngle(found.calibration.camera_from_imu.rotation.conjugate() * ImuMount().rotation);
    EXPECT_LT(angle, 0.3 * kRadPerDeg);
    EXPECT_LT(angle, 5 * found.calibration.rotation_sigma_rad);
    EXPECT_NEAR(found.calibration.time_offset_s, kOffset_s, 0.002);
    EXPECT_NEAR(found.calibration.time_offset_s, kOffset_s,
                5 * found.calibration.time_offset_sigma_s);
    // The prior of the bias is 0.01 rad/s. Its standard deviation from 57 independent turns over
    // 0.2 s is 0.002 sqrt(2) / 0.2 / sqrt(57) = 0.002, without the errors of the other unknowns.
    EXPECT_LT(found.gyro_bias_sigma_rad_per_s, 0.003);
    const Vector3d rest = found.gyro_bias_rad_per_s - recorded.bias.gyro_rad_per_s;
    EXPECT_LT(rest.norm(), 5 * found.gyro_bias_sigma_rad_per_s);
  }
}

TEST(AlignImu, IsUnknownWithoutMotion) {
  const ImuAlignment found = Recorded(1, 0.002).Align();
  EXPECT_EQ(found.fault, "");
  EXPECT_FALSE(found.is_known);
  EXPECT_FALSE(found.has_enough_motion);
}

TEST(AlignImu, FindsWrongSign) {
  Recorded recorded(2);
  for (ImuSample& sample : recorded.samples) sample.gyro_rad_per_s.y() *= -1;
  EXPECT_THAT(recorded.Align().fault, HasSubstr("mirror image"));
}

TEST(AlignImu, FindsExchangedAxes) {
  Recorded recorded(3);
  for (ImuSample& sample : recorded.samples)
    std::swap(sample.gyro_rad_per_s.x(), sample.gyro_rad_per_s.z());
  EXPECT_THAT(recorded.Align().fault, HasSubstr("mirror image"));
}

TEST(AlignImu, FindsDegrees) {
  Recorded recorded(4);
  for (ImuSample& sample : recorded.samples) sample.gyro_rad_per_s *= 180 / M_PI;
  EXPECT_THAT(recorded.Align().fault, HasSubstr("degrees per second"));
}

TEST(AlignImu, FindsSensorOfAnotherDevice) {
  Recorded recorded(5);
  const Recorded other(6);
  for (std::size_t i = 0; i < recorded.samples.size(); ++i) {
    recorded.samples[i].gyro_rad_per_s =
        other.samples[other.samples.size() - 1 - i].gyro_rad_per_s.cwiseAbs();
  }
  EXPECT_THAT(recorded.Align().fault, HasSubstr("does not follow"));
}

TEST(AlignImu, FindsWrongGivenRotation) {
  Recorded recorded(7);
  recorded.unknown.camera_from_imu = ImuMount();
  recorded.unknown.rotation_sigma_rad = 0.01;
  EXPECT_EQ(recorded.Align().fault, "");
  recorded.unknown.camera_from_imu.rotation =
      recorded.unknown.camera_from_imu.rotation * QuaternionExp<double>(Vector3d(0.3, 0, 0));
  EXPECT_THAT(recorded.Align().fault, HasSubstr("differs by 17"));
}

TEST(AlignImu, GivenRotationIsKnownWithoutTurns) {
  ImuCalibration given;
  given.rotation_sigma_rad = 0.01;
  std::vector<ImuSample> samples(2);
  samples[1].stamp_s = 1;
  EXPECT_TRUE(AlignImu(GyroIntegral(&samples), {}, given).is_known);
}

}  // namespace
}  // namespace surfit::testing
