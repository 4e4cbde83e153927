#include "finishing/stereo/stereo_keyframe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

// 640 columns, with a bright left half.
RgbdFrame HalfBrightFrame() {
  RgbdFrame frame;
  frame.index = 7;
  frame.depth_m = Image<float>(640, 480, 2.f);
  frame.color = Image<Rgb8>(640, 480, {20, 20, 20});
  for (const auto [u, v] : Pixels(0, 320, 0, 480)) frame.color(u, v) = {200, 200, 200};
  return frame;
}

constexpr PinholeCamera kCamera = {640, 480, 500, 500, 319.5, 239.5, {}};

TEST(StereoKeyframe, HasHalfTheResolution) {
  const RgbdFrame frame = HalfBrightFrame();
  const Rigid3d pose(Eigen::Quaterniond::Identity(), {1, 2, 3});
  const StereoKeyframe keyframe =
      MakeStereoKeyframe(frame, frame.depth_m, {kCamera, {}}, {}, pose, pose);
  EXPECT_EQ(keyframe.index, 7);
  EXPECT_EQ(keyframe.camera.width, 320);
  EXPECT_EQ(keyframe.camera.cx, 159.5);
  EXPECT_EQ(keyframe.color(159, 100), (Rgb8{200, 200, 200}));
  EXPECT_EQ(keyframe.color(160, 100), (Rgb8{20, 20, 20}));
  for (const auto [u, v] : PixelsOf(keyframe.measured_m)) {
    EXPECT_FLOAT_EQ(keyframe.measured_m(u, v), 2);
  }
}

TEST(StereoKeyframe, MovesDepthToThePoseOfTheColours) {
  const RgbdFrame frame = HalfBrightFrame();
  Image<float> depth_m(640, 480, 0.f);
  depth_m(300, 200) = 2;
  const Rigid3d to_the_right(Eigen::Quaterniond::Identity(), {0.08, 0, 0.5});
  const StereoKeyframe keyframe =
      MakeStereoKeyframe(frame, depth_m, {kCamera, {}}, {}, Rigid3d(), to_the_right);
  // The point at (-0.078, -0.158, 2) is at (-0.158, -0.158, 1.5).
  int seen = 0;
  for (const auto [u, v] : PixelsOf(keyframe.measured_m)) {
    if (!(keyframe.measured_m(u, v) > 0)) continue;
    ++seen;
    EXPECT_FLOAT_EQ(keyframe.measured_m(u, v), 1.5);
    EXPECT_NEAR(u, 159.5 - 250 * 0.158 / 1.5, 0.6);
    EXPECT_NEAR(v, 119.5 - 250 * 0.158 / 1.5, 0.6);
  }
  EXPECT_EQ(seen, 1);
}

TEST(StereoKeyframe, IsWithoutTheRotationDuringTheReadout) {
  // The edge is at the same ray at all rows of a global shutter. A turn about y moves it.
  const double readout_s = 0.03, turn_rad_per_s = 1;
  RgbdFrame frame = HalfBrightFrame();
  for (const auto [u, v] : PixelsOf(frame.color)) {
    const double t = (v - 239.5) / 480 * readout_s;
    const double edge = 319.5 - 500 * t * turn_rad_per_s;
    const std::uint8_t grey = u < edge ? 200 : 20;
    frame.color(u, v) = {grey, grey, grey};
  }
  CameraMotion motion;
  motion.angular_velocity_rad_per_s = {0, turn_rad_per_s, 0};
  const StereoKeyframe keyframe = MakeStereoKeyframe(frame, frame.depth_m, {kCamera, {}, readout_s},
                                                     motion, Rigid3d(), Rigid3d());
  for (int v = 20; v < 220; ++v) {
    int edge = 20;  // the first columns can be outside of the image
    while (edge < 320 && keyframe.color(edge, v).r > 110) ++edge;
    EXPECT_NEAR(edge, 159.75, 0.8) << v;
  }
}

}  // namespace
}  // namespace surfit::testing
