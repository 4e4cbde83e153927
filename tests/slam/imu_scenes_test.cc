// Slam with an inertial sensor, where depth alone does not suffice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/slam/slam.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

const PinholeCamera kCamera = {160, 120, 131, 131, 79.5, 59.5, {}};
constexpr double kPosesPerSecond = 60;

// Runs Slam on every `step`-th pose of a path, with the noise of a Kinect and with an inertial
// sensor. Each error is the distance of the camera from the true position, m; infinite without a
// pose.
std::vector<double> PositionErrors(const Scene& scene, const Trajectory& path, std::uint64_t seed,
                                   std::size_t step = 2) {
  Slam slam({kCamera, {}}, SlamOptions(), path[0].world_from_camera);
  ImuSimulation simulation;
  simulation.seed = seed;
  ImuRecording imu;
  imu.samples = SimulateImu(SmoothPath(path), simulation);
  imu.read_from = "simulation";
  imu.calibration.rotation_sigma_rad = 0.005;
  slam.UseImu(imu);
  std::vector<double> errors;
  for (std::size_t i = 0; i < path.size(); i += step) {
    const int index = static_cast<int>(i);
    RgbdFrame frame =
        RenderFrame(scene, kCamera, path[i].world_from_camera, index, path[i].stamp_s);
    frame.depth_m = KinectDepth(frame.depth_m, kCamera, i);
    const FrameReport report = slam.Process(frame);
    const Vector3d error =
        report.world_from_camera.translation - path[i].world_from_camera.translation;
    errors.push_back(report.HasPose() ? error.norm() : std::numeric_limits<double>::infinity());
  }
  return errors;
}

// Boxes and balls left of a bare wall. World z is up, and the wall is at y = 3 m.
Scene BareWall() {
  const auto gray = [](float value) {
    return [value](const Vector3d&) { return Eigen::Vector3f::Constant(value).eval(); };
  };
  Scene scene;
  const auto facing = [](const Vector3d& normal) {
    return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
  };
  scene.Add(MakeHalfSpace(), {facing(-Vector3d::UnitY()), {0, 3, 0}}, gray(0.7F));
  scene.Add(MakeHalfSpace(), {facing(Vector3d::UnitZ()), {0, 0, 0}}, gray(0.4F));
  scene.Add(MakeHalfSpace(), {facing(Vector3d::UnitX()), {-3.8, 0, 0}}, gray(0.5F));
  for (int i = 0; i < 6; ++i) {
    const Vector3d place(-3.6 + 0.25 * i, 2.2 + 0.1 * (i % 3), 0.5 + 0.35 * ((2 * i) % 6));
    const Rigid3d pose = {QuaternionExp<double>(Vector3d(0.3 * i, 0.5, 0.2 * i)), place};
    scene.Add(i % 2 == 0 ? MakeBox({0.3, 0.4, 0.25}) : MakeSphere(0.2), pose,
              gray(0.3F + 0.1F * i));
  }
  scene.lights.push_back({{0, 0, 2.5}});
  return scene;
}

// The camera looks at the boxes for 2 s, at the wall alone for 2 s, and at the boxes again.
Trajectory LookAwayPath() {
  Trajectory path;
  // Camera x right, y down, z forward along world y.
  const Eigen::Quaterniond level(Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()));
  const auto smooth = [](double t) {
    const double x = std::clamp(t, 0., 1.);
    return x * x * (3 - 2 * x);
  };
  for (int i = 0; i < 7 * kPosesPerSecond; ++i) {
    const double t = i / kPosesPerSecond;
    const double left = 0.85 * (1 - smooth(t - 2) + smooth(t - 5));
    const Vector3d shake(0.05 * std::sin(2.1 * t), 0.04 * std::sin(2.9 * t),
                         0.05 * std::sin(1.7 * t));
    const Vector3d place(0.1 * std::sin(1.9 * t), 0.08 * std::sin(2.3 * t),
                         1.5 + 0.1 * std::sin(1.3 * t));
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(left, Vector3d::UnitZ()));
    path.push_back({t, {turned * level * QuaternionExp<double>(shake), place}});
  }
  return path;
}

// The position along the wall is dead reckoning for three seconds. Registration slides by half a
// metre there.
TEST(SlamWithImu, SlidesAlongBareWallDoNotCorrectPrediction) {
  constexpr std::uint64_t kSensors = 8;
  double squares = 0;
  for (std::uint64_t seed = 0; seed < kSensors; ++seed) {
    const std::vector<double> errors = PositionErrors(BareWall(), LookAwayPath(), seed);
    const double most = *std::max_element(errors.begin(), errors.begin() + 160);
    EXPECT_LT(errors[60], 0.01);
    squares += most * most / static_cast<double>(kSensors);
  }
  EXPECT_LT(std::sqrt(squares), 0.25);
}

// Turns by up to 3 rad/s at one place of a room.
Trajectory SwingPath(const Rigid3d& world_from_place) {
  Trajectory path;
  for (int i = 0; i < 4 * kPosesPerSecond; ++i) {
    const double t = i / kPosesPerSecond;
    // The first half second is slow, so that the sensors start.
    const double size = std::min(1., t);
    const Vector3d turn(0.1 * std::sin(2.3 * t), 0.75 * size * std::sin(4 * t),
                        0.1 * std::sin(2.9 * t));
    const Vector3d shift(0.05 * std::sin(2 * t), 0.03 * std::sin(3 * t), 0.05 * std::sin(2.5 * t));
    path.push_back({t, world_from_place * Rigid3d(QuaternionExp<double>(turn), shift)});
  }
  return path;
}

// Without the sensor, 15 frames per second are too few for this motion.
TEST(SlamWithImu, SwungCameraIsAsAccurateAt15FramesPerSecondAsAt60) {
  const Scene room = MakeScene("room", 4);
  const Trajectory path = SwingPath(MakePath(room, 2, 4)[0].world_from_camera);
  const auto rms = [&](std::size_t step) {
    double squares = 0;
    const std::vector<double> errors = PositionErrors(room, path, 1, step);
    for (const double error : errors) squares += error * error;
    return std::sqrt(squares / static_cast<double>(errors.size()));
  };
  const double few_m = rms(4), many_m = rms(1);
  std::printf("%.5f m at 15 Hz, %.5f m at 60 Hz\n", few_m, many_m);
  EXPECT_LT(few_m, 1.3 * many_m);
}

}  // namespace
}  // namespace surfit::testing
