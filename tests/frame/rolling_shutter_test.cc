#include "frame/rolling_shutter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "surfit/frame/camera_motion.h"
#include "testing/pixels.h"

namespace surfit {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kReadout_s = 1. / 30;
const DepthSensor kSensor = {{kWidth, kHeight, 130, 130, 79.5, 59.5, {}}, {}, kReadout_s};
// Hand-held motion: about 60 deg/s and 0.5 m/s.
const CameraMotion kMotion = {{0.5, -0.8, 0.4}, {0.3, -0.2, 0.35}};

// Depth of a floor, a wall ahead and a wall at the side, along a ray of a camera at this pose.
double DepthAt(const Rigid3d& world_from_camera, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d direction = world_from_camera.rotation * ray;
  const Eigen::Vector3d& origin = world_from_camera.translation;
  double depth = 100;
  const auto meet = [&](int axis, double at) {
    const double z = (at - origin[axis]) / direction[axis];
    if (z > 0) depth = std::min(depth, z);
  };
  meet(0, 1.2), meet(1, 0.9), meet(2, 3);
  return depth;
}

Rigid3d ExtrapolatePose(double seconds) {
  return Rigid3d(QuaternionExp<double>(seconds * kMotion.angular_velocity_rad_per_s),
                 seconds * kMotion.velocity_m_per_s);
}

RgbdFrame FrameOf(double readout_s) {
  RgbdFrame frame;
  frame.depth_m = Image<float>(kWidth, kHeight);
  frame.color = Image<Rgb8>(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    const Rigid3d pose = ExtrapolatePose(((v + 0.5) / kHeight - 0.5) * readout_s);
    for (int u = 0; u < kWidth; ++u) {
      frame.depth_m(u, v) = static_cast<float>(DepthAt(pose, kSensor.camera.Ray(u, v)));
      frame.color(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 0};
    }
  }
  return frame;
}

// RMS difference of inverse depth without the image margin.
double Difference(const Image<float>& a, const Image<float>& b) {
  constexpr int kMargin = 8;
  double sum = 0;
  int count = 0;
  for (const auto [u, v] : testing::Pixels(kMargin, kWidth - kMargin, kMargin, kHeight - kMargin)) {
    EXPECT_GT(a(u, v), 0) << u << ' ' << v;
    const double difference = 1. / a(u, v) - 1. / b(u, v);
    sum += difference * difference;
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(RollingShutter, CorrectedFrameAgreesWithGlobalShutter) {
  const RgbdFrame global = FrameOf(0), rolling = FrameOf(kReadout_s);
  const RgbdFrame mended = CorrectRollingShutter(rolling, kSensor, kMotion);
  const double before = Difference(rolling.depth_m, global.depth_m);
  const double after = Difference(mended.depth_m, global.depth_m);
  EXPECT_GT(before, 1e-3);
  EXPECT_LT(after, before / 5);
}

TEST(RollingShutter, OppositeMotionIncreasesError) {
  const RgbdFrame global = FrameOf(0), rolling = FrameOf(kReadout_s);
  const CameraMotion opposite = {-kMotion.angular_velocity_rad_per_s, -kMotion.velocity_m_per_s};
  const RgbdFrame mended = CorrectRollingShutter(rolling, kSensor, opposite);
  EXPECT_GT(Difference(mended.depth_m, global.depth_m),
            1.5 * Difference(rolling.depth_m, global.depth_m));
}

TEST(RollingShutter, MovesColorWithDepth) {
  const RgbdFrame mended = CorrectRollingShutter(FrameOf(kReadout_s), kSensor, kMotion);
  // The top row was captured half a readout early. Far points move by the rotation only.
  const double tau = (10.5 / kHeight - 0.5) * kReadout_s;
  const double expected_u = 80 - 130 * tau * kMotion.angular_velocity_rad_per_s.y();
  EXPECT_NEAR(mended.color(80, 10).r, expected_u, 2.5);
  EXPECT_NE(mended.color(80, 10).r, 80);
}

TEST(RollingShutter, KeepsTheFrameWithoutReadoutOrMotion) {
  const RgbdFrame rolling = FrameOf(kReadout_s);
  const DepthSensor global = {kSensor.camera, kSensor.noise, 0};
  EXPECT_EQ(CorrectRollingShutter(rolling, global, kMotion).depth_m, rolling.depth_m);
  EXPECT_EQ(CorrectRollingShutter(rolling, kSensor, {}).depth_m, rolling.depth_m);
}

TEST(RollingShutter, KeepsMissingDepth) {
  RgbdFrame rolling = FrameOf(kReadout_s);
  std::fill(rolling.depth_m.begin(), rolling.depth_m.end(), 0.f);
  const RgbdFrame mended = CorrectRollingShutter(rolling, kSensor, kMotion);
  EXPECT_THAT(std::vector<float>(mended.depth_m.begin(), mended.depth_m.end()),
              ::testing::Each(0.f));
}

// Pose of a registration, to first order, after correction of a wrong motion: least squares of n .
// (d applied to X + tau (motion - taken)(X)).
Rigid3d PoseRegistering(const FrameLevel& surface, const CameraMotion& taken) {
  Eigen::Matrix<double, 6, 6> a_sum = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> b_sum = Eigen::Matrix<double, 6, 1>::Zero();
  for (const auto [u, v] : testing::Pixels(0, kWidth, 0, kHeight)) {
    const Eigen::Vector3d point = surface.vertex(u, v).cast<double>();
    const Eigen::Vector3d normal = surface.normal(u, v).cast<double>();
    const double tau = ((v + 0.5) / kHeight - 0.5) * kReadout_s;
    const Eigen::Vector3d turn =
        tau * (kMotion.angular_velocity_rad_per_s - taken.angular_velocity_rad_per_s);
    const Eigen::Vector3d way = tau * (kMotion.velocity_m_per_s - taken.velocity_m_per_s);
    Eigen::Matrix<double, 6, 1> a;
    a << point.cross(normal), normal;
    const double weight = std::pow(surface.noise.SigmaZ(point.z()), -2);
    a_sum += weight * a * a.transpose();
    b_sum += weight * a * normal.dot(turn.cross(point) + way);
  }
  // Rows are displaced by the remaining motion, and the pose compensates for it.
  const Eigen::Matrix<double, 6, 1> d = a_sum.ldlt().solve(b_sum);
  return {QuaternionExp<double>(d.head<3>()), d.tail<3>()};
}

// Surface of the floor and walls at the middle of the readout.
FrameLevel SurfaceAt(const Rigid3d& world_from_camera) {
  FrameLevel surface = {
      kSensor.camera, {}, VectorImage(kWidth, kHeight), VectorImage(kWidth, kHeight), {}};
  for (const auto [u, v] : testing::Pixels(0, kWidth, 0, kHeight)) {
    const Eigen::Vector3d ray = kSensor.camera.Ray(u, v);
    const Eigen::Vector3d point = DepthAt(world_from_camera, ray) * ray;
    const Eigen::Vector3d world = world_from_camera * point;
    const int axis = std::abs(world.x() - 1.2) < 1e-9   ? 0
                     : std::abs(world.y() - 0.9) < 1e-9 ? 1
                                                        : 2;
    surface.vertex.Set(u, v, point.cast<float>());
    surface.normal.Set(
        u, v,
        (world_from_camera.rotation.conjugate() * -Eigen::Vector3d::Unit(axis)).cast<float>());
  }
  return surface;
}

TEST(ReadoutCorrection, ReducesPoseErrorOfWrongMotionToTenPercent) {
  const double seconds = 1. / 30;
  const Rigid3d world_from_camera =
      ExtrapolatePose(seconds);  // the pose of the last frame is the identity
  const FrameLevel surface = SurfaceAt(world_from_camera);
  const CameraMotion half = {0.5 * kMotion.angular_velocity_rad_per_s,
                             0.5 * kMotion.velocity_m_per_s};
  for (const CameraMotion& taken : {CameraMotion(), half}) {
    const Rigid3d registered = world_from_camera * PoseRegistering(surface, taken);
    const Rigid3d corrected =
        registered *
        ReadoutCorrection(surface, kReadout_s, taken, MotionOver(registered, seconds), seconds);
    const Rigid3d before = world_from_camera.Inverse() * registered;
    const Rigid3d after = world_from_camera.Inverse() * corrected;
    EXPECT_GT(before.translation.norm(), 1e-3);
    EXPECT_LT(after.translation.norm(), 0.1 * before.translation.norm());
    EXPECT_LT(RotationAngle(after.rotation), 0.1 * RotationAngle(before.rotation));
  }
}

TEST(ReadoutCorrection, IsIdentityForPredictedMotionOrEmptyFrame) {
  const FrameLevel surface = SurfaceAt({});
  const Rigid3d same = ReadoutCorrection(surface, kReadout_s, kMotion, kMotion, 1. / 30);
  EXPECT_EQ(same.Matrix(), Rigid3d().Matrix());
  const FrameLevel empty = {
      kSensor.camera, {}, VectorImage(kWidth, kHeight), VectorImage(kWidth, kHeight), {}};
  EXPECT_EQ(ReadoutCorrection(empty, kReadout_s, {}, kMotion, 1. / 30).Matrix(),
            Rigid3d().Matrix());
}

TEST(ReadoutCorrection, ReturnsIdentityIfTheSurfaceDoesNotConstrainThePose) {
  const Eigen::Vector3d slanted = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const Eigen::Vector3d side = Eigen::Vector3d(-1, 0.1, 0.2).normalized();
  FrameLevel surface = SurfaceAt({});
  const auto add_plane = [&](const Eigen::Vector3d& normal, int begin, int end) {
    for (const auto [u, v] : testing::Pixels(begin, end, 0, kHeight)) {
      const Eigen::Vector3d ray = kSensor.camera.Ray(u, v);
      const Eigen::Vector3d point = -2 / std::min(-0.1, normal.dot(ray)) * ray;
      surface.vertex.Set(u, v, point.cast<float>());
      surface.normal.Set(u, v, normal.cast<float>());
    }
  };
  add_plane(slanted, 0, kWidth);
  EXPECT_EQ(ReadoutCorrection(surface, kReadout_s, {}, kMotion, 1. / 30).Matrix(),
            Rigid3d().Matrix());
  add_plane(side, kWidth / 2, kWidth);
  EXPECT_EQ(ReadoutCorrection(surface, kReadout_s, {}, kMotion, 1. / 30).Matrix(),
            Rigid3d().Matrix());
}

TEST(CameraMotion, AgreesWithConstantMotion) {
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) {
    const double stamp_s = 100 + i * 0.03125;
    trajectory.push_back({stamp_s, ExtrapolatePose(i * 0.03125)});
  }
  // A constant velocity in the world rotates in the camera frame, here by 0.03 rad per frame.
  const CameraMotion first = MotionAt(trajectory, trajectory[0].stamp_s);
  EXPECT_NEAR((first.angular_velocity_rad_per_s - kMotion.angular_velocity_rad_per_s).norm(), 0,
              1e-6);
  EXPECT_NEAR((first.velocity_m_per_s - kMotion.velocity_m_per_s).norm(), 0, 0.02);
  const CameraMotion inner = MotionAt(trajectory, trajectory[2].stamp_s);
  EXPECT_NEAR((inner.angular_velocity_rad_per_s - kMotion.angular_velocity_rad_per_s).norm(), 0,
              1e-6);
}

TEST(CameraMotion, IsZeroAcrossGapInTrajectory) {
  const Trajectory trajectory = {{1, ExtrapolatePose(0)}, {1.5, ExtrapolatePose(0.5)}};
  EXPECT_TRUE(MotionAt(trajectory, 1).IsZero());
  EXPECT_TRUE(MotionAt(trajectory, 1.2).IsZero());
  EXPECT_FALSE(MotionAt(trajectory, 1, 0.6).IsZero());
  EXPECT_TRUE(MotionOver(ExtrapolatePose(0.1), 0).IsZero());
}

}  // namespace
}  // namespace surfit
