// Gaussians of surfels, and their colours from images.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "apps/export/gaussians.h"
#include "surfit/core/parallel.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

constexpr float kSpacing_m = 0.02f;
const PinholeCamera kWallCamera = {160, 120, 160, 160, 79.5, 59.5, {}};

// Surfels on the plane z = 2 m, beyond the view of kWallCamera.
std::vector<Surfel> Wall() {
  std::vector<Surfel> surfels;
  for (int row = -50; row <= 50; ++row) {
    for (int column = -60; column <= 60; ++column) {
      Surfel surfel;
      surfel.position_in_world = {static_cast<float>(column) * kSpacing_m,
                                  static_cast<float>(row) * kSpacing_m, 2};
      surfel.normal_in_world = {0, 0, -1};
      surfel.radius_m = kSpacing_m;
      surfel.color = {10, 20, 30};
      surfels.push_back(surfel);
    }
  }
  return surfels;
}

bool IsInMiddle(const Gaussian& gaussian) {
  return std::abs(gaussian.position_m.x()) < 0.8f && std::abs(gaussian.position_m.y()) < 0.6f;
}

void FitTo(const Image<Rgb8>& image, std::vector<Gaussian>* gaussians) {
  FitColors(
      {ReducedView(image, kWallCamera, Rigid3d())}, [](int, int) {}, gaussians);
}

// The sixth neighbour on a grid is a diagonal one.
TEST(Gaussians, HaveSizesFromTheirSpacing) {
  int count = 0;
  for (const Gaussian& gaussian : GaussiansOf(Wall())) {
    if (!IsInMiddle(gaussian)) continue;
    ASSERT_NEAR(gaussian.sigma_m, 0.6 * std::sqrt(2.) * kSpacing_m, 1e-5);
    ++count;
  }
  EXPECT_GT(count, 4000);
}

TEST(GaussianColors, BecomeThoseOfTheImage) {
  std::vector<Gaussian> gaussians = GaussiansOf(Wall());
  FitTo(Image<Rgb8>(160, 120, {200, 100, 50}), &gaussians);
  for (const Gaussian& gaussian : gaussians) {
    if (!IsInMiddle(gaussian)) continue;
    ASSERT_NEAR(255 * gaussian.color.x(), 200, 4) << gaussian.position_m.transpose();
    ASSERT_NEAR(255 * gaussian.color.y(), 100, 2);
    ASSERT_NEAR(255 * gaussian.color.z(), 50, 1);
  }
}

// A wave of 16 px is 20 cm on the wall. Averages keep less than 0.9 of its amplitude.
TEST(GaussianColors, KeepTheContrastOfTheImage) {
  const auto wave = [](double x_m) { return 128 + 100 * std::sin(2 * M_PI * x_m / 0.2); };
  Image<Rgb8> image(160, 120);
  for (const auto [u, v] : PixelsOf(image)) {
    const auto value = static_cast<std::uint8_t>(wave(2 * (u - kWallCamera.cx) / kWallCamera.fx));
    image(u, v) = {value, value, value};
  }
  std::vector<Gaussian> gaussians = GaussiansOf(Wall());
  FitTo(image, &gaussians);
  double by_wave = 0, wave2 = 0;
  for (const Gaussian& gaussian : gaussians) {
    if (!IsInMiddle(gaussian)) continue;
    const double expected = wave(gaussian.position_m.x()) - 128;
    by_wave += expected * (255. * gaussian.color.x() - 128);
    wave2 += expected * expected;
  }
  EXPECT_GT(by_wave / wave2, 0.95);
}

TEST(GaussianColors, StayOutsideOfTheView) {
  std::vector<Gaussian> gaussians = GaussiansOf(Wall());
  const Gaussian before = gaussians.front();
  FitTo(Image<Rgb8>(160, 120, {200, 100, 50}), &gaussians);
  EXPECT_EQ(gaussians.front().color, before.color);
}

TEST(GaussianColors, AreTheSameAtAnyNumberOfThreads) {
  Image<Rgb8> image(160, 120);
  for (const auto [u, v] : PixelsOf(image)) {
    image(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 90};
  }
  std::vector<std::vector<Gaussian>> fitted(2, GaussiansOf(Wall()));
  for (int i = 0; i < 2; ++i) {
    const ThreadLimit limit(1 + 3 * i);
    FitTo(image, &fitted[i]);
  }
  for (std::size_t i = 0; i < fitted[0].size(); ++i) {
    ASSERT_EQ(fitted[0][i].color, fitted[1][i].color);
  }
}

TEST(ReducedViews, ShowMeansOfPixelsAtTheSameRays) {
  PinholeCamera camera = {640, 480, 500, 510, 320, 240, {}};
  Image<Rgb8> image(640, 480);
  image(0, 0) = {40, 80, 120};
  image(1, 1) = {80, 0, 0};
  const GaussianView view = ReducedView(image, camera, Rigid3d());
  EXPECT_EQ(view.camera.width, 320);
  EXPECT_EQ(view.color(0, 0), Rgb8({30, 20, 30}));
  EXPECT_FLOAT_EQ(view.dilation_px2, 0.075f);
  // The middle of pixels 0 and 1.
  const Eigen::Vector3d ray = view.camera.Ray(0, 0);
  EXPECT_NEAR(ray.x(), (0.5 - camera.cx) / camera.fx, 1e-12);
  EXPECT_NEAR(ray.y(), (0.5 - camera.cy) / camera.fy, 1e-12);
}

}  // namespace
}  // namespace surfit::testing
