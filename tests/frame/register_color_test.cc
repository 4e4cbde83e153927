#include "frame/register_color.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "surfit/core/lanes.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

BilinearTap TapAtPixel(float u, float v, int width, int height) {
  using V = Lanes<float>;
  std::int32_t steps_u[V::kCount], steps_v[V::kCount];
  TapSteps(V(u), width).StoreTruncated(steps_u);
  TapSteps(V(v), height).StoreTruncated(steps_v);
  return TapAt(steps_u[0], steps_v[0], width, height);
}

TEST(SampleBilinear, IsExactAtPixelCentresAndBorder) {
  Image<Rgb8> image(4, 3);
  for (const auto [u, v] : PixelsOf(4, 3))
    image(u, v) = {static_cast<std::uint8_t>(50 * u + 3 * v), 255, 0};
  for (const auto [u, v] : PixelsOf(4, 3)) {
    const float centre_u = static_cast<float>(u), centre_v = static_cast<float>(v);
    EXPECT_EQ(SampleBilinear(image, TapAtPixel(centre_u, centre_v, 4, 3)), image(u, v))
        << u << " " << v;
  }
  EXPECT_EQ(SampleBilinear(image, TapAtPixel(-0.4f, 2.4f, 4, 3)), image(0, 2));
  EXPECT_EQ(SampleBilinear(image, TapAtPixel(1.5f, 0.5f, 4, 3)).r, 77);  // 76.5 rounded
  EXPECT_EQ(SampleBilinear(image, BilinearTap()), Rgb8());
}

// The definition in real numbers is exact here, including the rounding.
TEST(SampleBilinear, IsRoundedMeanOfFourPixels) {
  Image<Rgb8> image(3, 3);
  std::mt19937_64 rng(8);
  std::uniform_int_distribution<int> byte(0, 3);
  const auto extreme = [&] { return static_cast<std::uint8_t>(85 * byte(rng)); };
  for (Rgb8& color : image) color = {extreme(), extreme(), extreme()};
  for (int steps_v = 0; steps_v <= 512; steps_v += 2) {
    for (int steps_u = 0; steps_u <= 512; ++steps_u) {
      const Rgb8 sample = SampleBilinear(image, TapAt(steps_u, steps_v, 3, 3));
      const int u = std::min(steps_u / 256, 1), v = std::min(steps_v / 256, 1);
      const double right = steps_u / 256. - u, low = steps_v / 256. - v;
      const auto mean = [&](std::uint8_t Rgb8::*channel) {
        return (1 - low) * ((1 - right) * image(u, v).*channel + right * image(u + 1, v).*channel) +
               low *
                   ((1 - right) * image(u, v + 1).*channel + right * image(u + 1, v + 1).*channel);
      };
      ASSERT_EQ(sample.r, std::floor(mean(&Rgb8::r) + 0.5)) << steps_u << " " << steps_v;
      ASSERT_EQ(sample.g, std::floor(mean(&Rgb8::g) + 0.5));
      ASSERT_EQ(sample.b, std::floor(mean(&Rgb8::b) + 0.5));
    }
  }
}

// Colour camera with another lens, image size, position and rotation than the depth camera.
RgbdCamera TwoCameras() {
  RgbdCamera camera;
  camera.depth = {64, 48, 58, 57, 31, 24.5, {}};
  camera.color = {128, 96, 105, 106, 65, 46, {0.05, -0.02, 0.001, -0.002, 0}};
  camera.color_is_registered = false;
  camera.color_from_depth =
      Rigid3d(QuaternionExp<double>({0.02, -0.03, 0.01}), {0.05, -0.02, 0.01});
  return camera;
}

// The red value is the column of a pixel, and the green value is the row. Bilinear interpolation of
// these ramps is exact, except for the tap (1/512) and the rounding (1/2).
constexpr double kColorTolerance = 0.503;

Image<Rgb8> Ramps(const PinholeCamera& camera) {
  Image<Rgb8> ramps(camera.width, camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    ramps(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 99};
  }
  return ramps;
}

// Colour pixel of a depth pixel, by 4 x 4 matrices and the formula of OpenCV.
Eigen::Vector2d ExpectedPixel(const RgbdCamera& c, int u, int v, double depth) {
  const Eigen::Vector4d in_depth(depth * (u - c.depth.cx) / c.depth.fx,
                                 depth * (v - c.depth.cy) / c.depth.fy, depth, 1);
  const Eigen::Vector4d p = c.color_from_depth.Matrix() * in_depth;
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const auto& k = c.color.distortion;
  const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
  return {c.color.fx * (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + c.color.cx,
          c.color.fy * (y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + c.color.cy};
}

int CheckAgainstExpectedPixels(const RgbdCamera& camera, const Image<float>& depth_m,
                               const Image<Rgb8>& registered) {
  int seen = 0;
  for (const auto [u, v] : PixelsOf(depth_m)) {
    const Rgb8 color = registered(u, v);
    const Eigen::Vector2d pixel = ExpectedPixel(camera, u, v, depth_m(u, v));
    const bool inside = pixel.x() > 0 && pixel.y() > 0 && pixel.x() < camera.color.width - 1 &&
                        pixel.y() < camera.color.height - 1;
    if (!inside) continue;
    ++seen;
    EXPECT_EQ(color.b, 99);
    EXPECT_NEAR(color.r, pixel.x(), kColorTolerance);
    EXPECT_NEAR(color.g, pixel.y(), kColorTolerance);
  }
  return seen;
}

TEST(ColorRegistration, SamplesProjectionOfEachDepthPoint) {
  const RgbdCamera camera = TwoCameras();
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<float> depth(0.4f, 4.f);
  Image<float> depth_m(64, 48);
  for (float& d : depth_m) d = depth(rng);
  const auto registered = ColorRegistration(camera, 1).Apply(Ramps(camera.color), depth_m);
  EXPECT_GT(CheckAgainstExpectedPixels(camera, depth_m, registered), 2000);
}

// Direction of the parallax. The origin of a colour camera to the right of the depth camera is (+b,
// 0, 0) in depth coordinates, so color_from_depth is the translation (-b, 0, 0). The image of a
// near point is shifted to the left by f b / z.
TEST(ColorRegistration, CameraToTheRightShiftsNearPointsLeft) {
  RgbdCamera camera;
  camera.depth = {64, 48, 60, 60, 32, 24, {}};
  camera.color = camera.depth;
  camera.color_is_registered = false;
  camera.color_from_depth.translation = {-0.1, 0, 0};
  const Image<float> depth_m(64, 48, 1.f);
  const auto registered = ColorRegistration(camera, 1).Apply(Ramps(camera.color), depth_m);
  EXPECT_EQ(registered(32, 24), (Rgb8{32 - 6, 24, 99}));
  EXPECT_EQ(registered(2, 24), Rgb8());  // left of the colour camera's image
}

TEST(ColorRegistration, PixelsWithoutDepthHaveNoColorWithTranslation) {
  const RgbdCamera camera = TwoCameras();
  const Image<float> nothing(64, 48, 0.f);
  const auto registered = ColorRegistration(camera, 1).Apply(Ramps(camera.color), nothing);
  EXPECT_EQ(registered, Image<Rgb8>(64, 48));
}

TEST(ColorRegistration, PixelsWithoutDepthHaveColorWithoutTranslation) {
  RgbdCamera camera = TwoCameras();
  camera.color_from_depth.translation.setZero();
  const Image<float> nothing(64, 48, 0.f), one(64, 48, 1.f);
  const auto registered = ColorRegistration(camera, 1).Apply(Ramps(camera.color), nothing);
  EXPECT_GT(CheckAgainstExpectedPixels(camera, one, registered), 2000);
}

TEST(ColorRegistration, KeepsRegisteredColorOfPinholeCamera) {
  RgbdCamera camera = TwoCameras();
  camera.color_is_registered = true;
  const Image<Rgb8> color = Ramps(camera.depth);
  EXPECT_EQ(ColorRegistration(camera, 1).Apply(color, Image<float>(64, 48)), color);
}

}  // namespace
}  // namespace surfit::testing
