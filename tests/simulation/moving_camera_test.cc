// Tests of a camera that moves during exposure and readout.
#include <gmock/gmock.h>

#include <cmath>

#include "frame/rolling_shutter.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr double kFrame_s = 1. / 30;

RgbdCamera SmallCamera() {
  RgbdCamera camera;
  camera.depth = {80, 60, 65, 66, 39, 30.5, {}};
  return camera;
}

// Oscillation with at most 1.5 rad/s and a width of 0.3 m. The second derivative of the position is
// zero at both ends.
constexpr double kOmega = 2 * M_PI, kAngle = 0.25, kWay_m = 0.15;

Rigid3d SwingAt(double t) {
  const double s = std::sin(kOmega * t);
  return {QuaternionExp<double>({0, kAngle * s, 0}), {kWay_m * s, 0, 0}};
}

Trajectory Swing() {
  Trajectory poses;
  for (int i = 0; i <= 60; ++i) poses.push_back({i * kFrame_s, SwingAt(i * kFrame_s)});
  return poses;
}

TEST(SmoothPath, ReproducesItsPosesExactly) {
  const SmoothPath path(Swing());
  for (const StampedPose& pose : path.poses()) {
    EXPECT_EQ(path.At(pose.stamp_s).Matrix(), pose.world_from_camera.Matrix());
  }
}

// A cubic spline has an error of at most 5/384 h^4 times the fourth derivative (Hall and Meyer
// 1976). The bound requires correct second derivatives at its ends, which holds for positions. The
// error of wrong end conditions decreases by a factor of 3.7 per pose and is zero after fifteen
// poses. With the half angle b = kAngle / 2 times the sine, the fourth derivative of the
// quaternions is at most kOmega^4 (b + 7 b^2 + 6 b^3 + b^4). The angle error is twice the
// quaternion error.
TEST(SmoothPath, HasErrorOfCubicSpline) {
  const SmoothPath path(Swing());
  const double spline = 5. / 384 * std::pow(kFrame_s * kOmega, 4), b = kAngle / 2;
  const double angle = 2 * spline * (b + 7 * b * b + 6 * b * b * b + b * b * b * b);
  double largest = 0;
  for (double t = 0.5; t < 1.5; t += 0.0017) {
    const Rigid3d error = SwingAt(t).Inverse() * path.At(t);
    EXPECT_LT(error.translation.norm(), spline * kWay_m * (1 + 1e-6));
    EXPECT_LT(RotationAngle(error.rotation), angle);
    largest = std::max(largest, error.translation.norm());
  }
  EXPECT_GT(largest, 0.1 * spline * kWay_m);  // the bound is tight
}

TEST(SmoothPath, ExtrapolatesAtConstantSpeed) {
  const SmoothPath path(Swing());
  const auto position = [&](double t) { return path.At(t).translation.x(); };
  for (const double end : {0., 2.}) {
    const double outward = end == 0 ? -0.01 : 0.01;
    const double speed = (position(end + outward) - position(end)) / outward;
    EXPECT_NEAR(position(end + 3 * outward), position(end) + 3 * outward * speed, 1e-12);
    // Speed of the oscillation. The error bound is the derivative of the spline error: h^3 / 24 of
    // the fourth derivative.
    EXPECT_NEAR(speed, kOmega * kWay_m, std::pow(kFrame_s, 3) / 24 * kWay_m * std::pow(kOmega, 4));
  }
}

class MovingCameraTest : public ::testing::Test {
 protected:
  static constexpr int kAt = 3;

  Rendering PlainAt(const Rigid3d& pose) const { return Render(scene_, camera_.depth, pose); }
  Rigid3d PathAt(double stamp_s) const { return SmoothPath(path_).At(stamp_s); }

  const Scene scene_ = MakeScene("room", 3);
  const Trajectory path_ = MakePath(scene_, 8, 3);
  RgbdCamera camera_ = SmallCamera();
};

TEST_F(MovingCameraTest, AgreesWithRenderWithoutEffects) {
  const Rigid3d pose = path_[kAt].world_from_camera;
  const Rendering plain = PlainAt(pose);
  const Rendering frame = MovingCamera(scene_, camera_, path_).Frame(kAt);
  EXPECT_TRUE(frame.depth_m == plain.depth_m);
  EXPECT_TRUE(frame.color == plain.color);
  const auto still = [&](int) { return pose; };
  const Rendering rows = RenderRows(scene_, camera_.depth, still);
  EXPECT_TRUE(rows.depth_m == plain.depth_m);
  EXPECT_TRUE(rows.surface == plain.surface);
  const LightImage light = RenderLight(scene_, camera_.depth, still);
  EXPECT_TRUE(ToSrgbImage(light, Eigen::Vector3f::Ones()) == plain.color);
}

TEST_F(MovingCameraTest, RendersEachRowAtItsCaptureTime) {
  camera_.readout_s = 0.03;
  camera_.color_latency_s = 0.011;
  ColorOptions options;
  options.color_readout_s = 0.02;
  const MovingCamera moving(scene_, camera_, path_, options);
  const Rendering frame = moving.Frame(kAt);
  const double stamp_s = path_[kAt].stamp_s;
  int moved = 0;
  for (const int v : {0, 1, 29, 44, 59}) {
    const double late = (v + 0.5) / 60 - 0.5;
    const Rigid3d depth_pose = PathAt(stamp_s + 0.03 * late);
    const Rigid3d color_pose = PathAt(stamp_s - 0.011 + 0.02 * late);
    EXPECT_EQ(moving.DepthPose(kAt, v).Matrix(), depth_pose.Matrix());
    EXPECT_EQ(moving.ColorPose(kAt, v).Matrix(), color_pose.Matrix());
    const Rendering geometry = PlainAt(depth_pose), colors = PlainAt(color_pose);
    const Rendering middle = PlainAt(path_[kAt].world_from_camera);
    for (int u = 0; u < 80; ++u) {
      EXPECT_EQ(frame.depth_m(u, v), geometry.depth_m(u, v));
      EXPECT_EQ(frame.surface(u, v), geometry.surface(u, v));
      EXPECT_EQ(frame.normal(u, v), geometry.normal(u, v));
      EXPECT_EQ(frame.color(u, v), colors.color(u, v));
      moved += frame.depth_m(u, v) != middle.depth_m(u, v);
    }
  }
  EXPECT_GT(moved, 300);
}

// The camera rotates by 0.5 to 1.5 degrees per frame. Half of the rows are captured more than a
// quarter of a frame from the middle. Their pixels are displaced by 262 px * 0.0087 / 4 = 0.6 px or
// more, up to six times as much. The correction to the nearest pixel leaves at most 0.5 px, and
// 0.25 px on average.
TEST_F(MovingCameraTest, IsInvertedByReadoutCorrection) {
  camera_.depth = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  camera_.readout_s = kFrame_s;
  const MovingCamera moving(scene_, camera_, path_);
  const RgbdFrame rolled = {kAt, path_[kAt].stamp_s, 0, moving.Frame(kAt).depth_m, {}};
  const RgbdFrame undone = CorrectRollingShutter(rolled, {camera_.depth, {}, camera_.readout_s, {}},
                                                 MotionAt(path_, path_[kAt].stamp_s));
  const Image<float> truth = PlainAt(path_[kAt].world_from_camera).depth_m;
  const auto far_off = [&](const Image<float>& depth_m) {
    int count = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      count += depth_m[i] > 0 && std::abs(depth_m[i] - truth[i]) > 0.002 * truth[i];
    }
    return count;
  };
  EXPECT_GT(far_off(rolled.depth_m), 320 * 240 / 20);
  EXPECT_LT(far_off(undone.depth_m), far_off(rolled.depth_m) / 2);
}

TEST_F(MovingCameraTest, BlursToMeanOfExposureSamples) {
  ColorOptions options;
  options.exposure_s = 0.2;
  options.exposure_samples = 3;
  const Rendering blurred = MovingCamera(scene_, camera_, path_, options).Frame(kAt);
  LightImage mean(80, 60, Eigen::Vector3f::Zero());
  for (int k = 0; k < 3; ++k) {  // three samples at equal intervals of the exposure
    const Rigid3d pose = PathAt(path_[kAt].stamp_s + ((k + 0.5) / 3 - 0.5) * 0.2);
    const LightImage light = RenderLight(scene_, camera_.depth, [&](int) { return pose; });
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += light[i] / 3;
  }
  const Image<Rgb8> expected = ToSrgbImage(mean, Eigen::Vector3f::Ones());
  // Another order of summation can round to the next grey value.
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(blurred.color[i].g, expected[i].g, 1);
  }
  const Rendering sharp = PlainAt(path_[kAt].world_from_camera);
  EXPECT_FALSE(blurred.color == sharp.color);
  EXPECT_TRUE(blurred.depth_m == sharp.depth_m);
}

TEST_F(MovingCameraTest, DoesNotBlurWithoutExposureOrMotion) {
  ColorOptions options;
  options.channel_gains = {1, 1, 1};  // enables the code path with effects
  const Rendering sharp = PlainAt(path_[kAt].world_from_camera);
  EXPECT_TRUE(MovingCamera(scene_, camera_, path_, options).Frame(kAt).color == sharp.color);
  options.exposure_s = 0.1;
  options.exposure_samples = 4;  // the sums of four samples are exact
  const Trajectory still = {{0, path_[kAt].world_from_camera}};
  EXPECT_TRUE(MovingCamera(scene_, camera_, still, options).Frame(0).color == sharp.color);
}

double Srgb(double linear) {
  const double x = std::min(linear, 1.);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

// Light is rounded to 1/4095, which is at most 12.92 * 255 / 4095 / 2 = 0.4 grey values. The grey
// value is rounded to an integer.
TEST_F(MovingCameraTest, MultipliesLightByGains) {
  ColorOptions options;
  options.channel_gains = {1.7, 1, 0.4};
  const Rendering frame = MovingCamera(scene_, camera_, path_, options).Frame(kAt);
  const LightImage light =
      RenderLight(scene_, camera_.depth, [&](int) { return path_[kAt].world_from_camera; });
  for (std::size_t i = 0; i < light.size(); ++i) {
    EXPECT_NEAR(frame.color[i].r, Srgb(1.7 * light[i].x()), 0.91);
    EXPECT_NEAR(frame.color[i].g, Srgb(light[i].y()), 0.91);
    EXPECT_NEAR(frame.color[i].b, Srgb(0.4 * light[i].z()), 0.91);
  }
}

// Exposure and white balance are set from the first frame, rendered with a width of 80 px.
TEST_F(MovingCameraTest, ExposesFirstFrameToMeanGrey) {
  ColorOptions options;
  options.auto_exposure_lag_s = 0.5;
  options.auto_white_balance_lag_s = 0.5;
  const MovingCamera moving(scene_, camera_, path_, options);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const LightImage light =
      RenderLight(scene_, camera_.depth, [&](int) { return path_[0].world_from_camera; });
  for (const Eigen::Vector3f& l : light) mean += l.cast<double>() / light.size();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(moving.gains(0)[c] * mean[c], 0.18, 1e-6);
}

// The light doubles at the second frame. The gain changes at the third frame.
TEST(ColorGains, FollowStepWithLag) {
  ColorOptions options;
  options.auto_exposure_lag_s = 0.2;
  options.channel_gains = {1, 1, 0.5};
  std::vector<Eigen::Vector3d> light(20, Eigen::Vector3d::Constant(0.36));
  light[0].setConstant(0.18);
  const auto gains = ColorGains(light, 30, options);
  ASSERT_EQ(gains.size(), light.size());
  EXPECT_NEAR(gains[0].x(), 1, 1e-6);
  for (int i = 1; i < 20; ++i) {
    const double expected = std::exp(std::log(0.5) * (1 - std::exp(-(i - 1) / (30 * 0.2))));
    EXPECT_NEAR(gains[i].x(), expected, 1e-6);
    EXPECT_NEAR(gains[i].z(), expected / 2, 1e-6);
  }
}

TEST(ColorGains, BalanceSceneToGrey) {
  ColorOptions options;
  options.auto_white_balance_lag_s = 0.2;
  const auto gains = ColorGains({{0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}}, 30, options);
  for (const Eigen::Vector3f& gain : gains) {
    EXPECT_NEAR(gain.x() * 0.3, 0.2, 1e-6);
    EXPECT_NEAR(gain.y() * 0.2, 0.2, 1e-6);
    EXPECT_NEAR(gain.z() * 0.1, 0.2, 1e-6);
  }
}

TEST(ColorGains, AreConstantWithoutLag) {
  for (const Eigen::Vector3f& gain : ColorGains({{0.3, 0.2, 0.1}, {0, 0, 0}}, 30, {})) {
    EXPECT_EQ(gain, Eigen::Vector3f::Ones());
  }
}

TEST(ColorOptions, RejectInvalidGains) {
  for (const std::vector<double>& gains : {std::vector<double>{1, 2}, {1, 0, 1}, {1, 1, -1}}) {
    ColorOptions options;
    options.channel_gains = gains;
    ExpectInputError([&] { Validate(options); }, Names("channel_gains"));
  }
}

}  // namespace
}  // namespace surfit::testing
