#include "surfit/frame/rectify_frame.h"

#include <limits>

#include "frame/lens.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

RgbdCamera SmallRgbdCamera() {
  RgbdCamera camera;
  camera.depth = {5, 3, 10, 10, 2, 1, {}};
  camera.depth_units_per_metre = 1000;
  return camera;
}

RectifyOptions Options(int downsample, double max_depth_m = 8) {
  RectifyOptions options;
  options.downsample = downsample;
  options.max_depth_m = max_depth_m;
  return options;
}

TEST(FrameRectifier, ConvertsCountsToMetres) {
  Image<std::uint16_t> raw(5, 3, 2500);
  raw(0, 0) = 0;
  raw(1, 0) = 65535;
  raw(2, 0) = 8000;  // at the limit
  raw(3, 0) = 8001;  // above the limit
  const RgbdFrame frame = FrameRectifier(SmallRgbdCamera(), Options(1)).Rectify(raw, {});
  EXPECT_EQ(frame.depth_m(0, 0), 0);
  EXPECT_EQ(frame.depth_m(1, 0), 0);
  EXPECT_EQ(frame.depth_m(2, 0), 8);
  EXPECT_EQ(frame.depth_m(3, 0), 0);
  EXPECT_EQ(frame.depth_m(4, 0), 2.5f);
  EXPECT_TRUE(frame.color.empty());
}

TEST(FrameRectifier, InvalidCodeIsMissingBelowMaxDepth) {
  Image<std::uint16_t> raw(5, 3, 65535);
  raw(0, 0) = 65534;
  const RgbdFrame frame = FrameRectifier(SmallRgbdCamera(), Options(1, 100)).Rectify(raw, {});
  EXPECT_EQ(frame.depth_m(0, 0), 65.534f);
  EXPECT_EQ(frame.depth_m(1, 0), 0);
}

TEST(FrameRectifier, ReadsFloatsAsMetresAndRemovesInvalidDepth) {
  Image<float> raw(5, 3, 1.25f);
  raw(0, 0) = std::numeric_limits<float>::quiet_NaN();
  raw(1, 0) = std::numeric_limits<float>::infinity();
  raw(2, 0) = -1;
  raw(3, 0) = 0;
  raw(4, 0) = 8.5f;
  const RgbdFrame frame = FrameRectifier(SmallRgbdCamera(), Options(1)).Rectify(raw, {});
  for (int u = 0; u < 5; ++u) EXPECT_EQ(frame.depth_m(u, 0), 0) << u;
  EXPECT_EQ(frame.depth_m(0, 1), 1.25f);
}

// z = f b / d: 500 px * 0.1 m = 50 m px.
TEST(FrameRectifier, ConvertsDisparitiesToMetres) {
  RgbdCamera camera = SmallRgbdCamera();
  camera.disparity = {500, 0.1, 16, 0};
  Image<std::uint16_t> raw(5, 3, 400);  // 25 px
  raw(0, 0) = 0;
  raw(1, 0) = 65535;
  raw(2, 0) = 99;  // 8.08 m: beyond the limit
  raw(3, 0) = 101;
  const RgbdFrame frame = FrameRectifier(camera, Options(1)).Rectify(raw, {});
  EXPECT_EQ(frame.depth_m(0, 0), 0);
  EXPECT_EQ(frame.depth_m(1, 0), 0);
  EXPECT_EQ(frame.depth_m(2, 0), 0);
  EXPECT_FLOAT_EQ(frame.depth_m(3, 0), 50 * 16 / 101.f);
  EXPECT_EQ(frame.depth_m(4, 0), 2);

  Image<float> pixels(5, 3, 25 * 16);
  pixels(0, 0) = std::numeric_limits<float>::quiet_NaN();
  pixels(1, 0) = -3;
  const RgbdFrame of_floats = FrameRectifier(camera, Options(1)).Rectify(pixels, {});
  EXPECT_EQ(of_floats.depth_m(0, 0), 0);
  EXPECT_EQ(of_floats.depth_m(1, 0), 0);
  EXPECT_EQ(of_floats.depth_m(2, 0), 2);
}

// Counts of Kinect v1 increase with depth. 2047 is invalid.
TEST(FrameRectifier, SupportsCountsThatDecreaseWithDisparity) {
  RgbdCamera camera = SmallRgbdCamera();
  camera.disparity = {580, 0.075, -8, 1090};
  Image<std::uint16_t> raw(5, 3, 1090 - 8 * 20);
  raw(0, 0) = 2047;
  raw(1, 0) = 1090;
  const RgbdFrame frame = FrameRectifier(camera, Options(1)).Rectify(raw, {});
  EXPECT_EQ(frame.depth_m(0, 0), 0);
  EXPECT_EQ(frame.depth_m(1, 0), 0);
  EXPECT_FLOAT_EQ(frame.depth_m(2, 0), 580 * 0.075f / 20);
}

TEST(FrameRectifier, DownsamplingKeepsRaysOfKeptPixels) {
  Image<std::uint16_t> raw(5, 3);
  Image<Rgb8> color(5, 3);
  for (const auto [u, v] : PixelsOf(5, 3)) {
    raw(u, v) = static_cast<std::uint16_t>(1000 + 10 * v + u);
    color(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 7};
  }
  const FrameRectifier rectifier(SmallRgbdCamera(), Options(2));
  const RgbdFrame frame = rectifier.Rectify(raw, color);
  ASSERT_EQ(frame.depth_m.width(), 3);
  ASSERT_EQ(frame.depth_m.height(), 2);
  for (const auto [u, v] : PixelsOf(3, 2)) {
    EXPECT_EQ(frame.depth_m(u, v), raw(2 * u, 2 * v) / 1000.f);
    EXPECT_EQ(frame.color(u, v), color(2 * u, 2 * v));
    EXPECT_EQ(rectifier.pinhole().Ray(u, v), SmallRgbdCamera().depth.Ray(2 * u, 2 * v));
  }
}

// Distorts an image whose depth is a smooth function of the ray, and prepares it. Each pixel of the
// frame must have the depth of its undistorted ray.
TEST(FrameRectifier, RemovesLensDistortion) {
  RgbdCamera camera;
  camera.depth = {640, 480, 517.3, 516.5, 318.6, 255.3, {.2624, -.9531, -.0054, .0026, 1.1633}};
  camera.depth_units_per_metre = 10000;
  const auto depth_of_ray = [](const Eigen::Vector3d& ray) { return 2 + ray.x() + 0.5 * ray.y(); };
  const auto red_of_ray = [](const Eigen::Vector3d& ray) { return 128 + 100 * ray.x(); };
  const Lens<double> lens(camera.depth);
  Image<std::uint16_t> raw(640, 480);
  Image<Rgb8> color(640, 480);
  for (const auto [u, v] : PixelsOf(640, 480)) {
    // Ray of the distorted pixel (u, v), by fixed-point iteration.
    Eigen::Vector3d ray = camera.depth.Ray(u, v);
    for (int i = 0; i < 30; ++i) {
      const LensPixel<double> pixel = lens.Project(ray);
      ray.x() += (u - pixel.u) / camera.depth.fx;
      ray.y() += (v - pixel.v) / camera.depth.fy;
    }
    raw(u, v) = static_cast<std::uint16_t>(std::lround(10000 * depth_of_ray(ray)));
    color(u, v).r = static_cast<std::uint8_t>(std::lround(red_of_ray(ray)));
  }
  const FrameRectifier rectifier(camera, Options(1));
  EXPECT_FALSE(rectifier.pinhole().HasDistortion());
  const RgbdFrame frame = rectifier.Rectify(raw, color);
  int seen = 0;
  for (const auto [u, v] : PixelsOf(640, 480)) {
    if (frame.depth_m(u, v) == 0) continue;
    ++seen;
    const Eigen::Vector3d ray = rectifier.pinhole().Ray(u, v);
    // The nearest pixel is at most 0.5 px away in u and v. The lens shrinks the image by at most
    // 1.4, so the error of the ray is 0.5 * 1.4 / 516 per axis, and the depth error 1.5 times that.
    EXPECT_NEAR(frame.depth_m(u, v), depth_of_ray(ray), 1.5 * 0.5 * 1.4 / 516 + 1e-4);
    // Two roundings of half a grey value each. The gradient is 0.2 grey values per pixel, and the
    // error of the tap is 1/512 px.
    EXPECT_NEAR(frame.color(u, v).r, red_of_ray(ray), 1.01);
  }
  EXPECT_GT(seen, 640 * 480 * 9 / 10);
}

TEST(FrameRectifier, RejectsInvalidOptionsAndCameras) {
  const RgbdCamera camera = SmallRgbdCamera();
  ExpectInputError([&] { FrameRectifier(camera, Options(0)); }, Names("downsample", 0));
  ExpectInputError([&] { FrameRectifier(camera, Options(17)); }, Names("downsample", 17));
  ExpectInputError([&] { FrameRectifier(camera, Options(1, 0)); }, Names("max_depth_m", 0));
  RgbdCamera upside_down = camera;
  upside_down.depth.fy = -10;
  ExpectInputError([&] { FrameRectifier(upside_down, Options(1)); }, Names("fy", -10));
  RgbdCamera tiny = camera;
  tiny.depth.width = 1;
  ExpectInputError([&] { FrameRectifier(tiny, Options(1)); }, Names(1, 3));
}

}  // namespace
}  // namespace surfit::testing
