#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "simulation/sensor_views.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

PinholeCamera PhoneCamera() { return {256, 192, 180.3, 180.3, 127.5, 95.5, {}}; }

LidarOptions ExactDots() {
  LidarOptions options;
  options.noise = {0, 0, 0};
  return options;
}

TEST(Lidar, HasNoHoles) {
  const Rendering exact = StepView(PhoneCamera(), 1, 3, 80, 180, {40, 40, 40}, kWhite);
  const SensorImage measured = LidarDepth(exact, PhoneCamera(), 1);
  EXPECT_EQ(MissingRatio(measured), 0);
  ASSERT_EQ(measured.confidence.size(), exact.depth_m.size());
}

TEST(Lidar, PlanesHaveNoBias) {
  const Rendering exact = PlaneView(PhoneCamera(), 2, 0.6, Squares);
  const SensorImage measured = LidarDepth(exact, PhoneCamera(), 1, ExactDots());
  for (std::size_t i = 0; i < exact.depth_m.size(); ++i) {
    // Floats, and the ridge of 1e-9 of the fit.
    ASSERT_NEAR(measured.depth_m[i], exact.depth_m[i], 3e-7 * exact.depth_m[i]) << i;
  }
}

TEST(Lidar, NoiseHasTheReportedSigma) {
  const PinholeCamera camera = {64, 48, 45, 45, 31.5, 23.5, {}};
  const Rendering exact = PlaneView(camera, 2, 0.4, Squares);
  double sum = 0, count = 0, frame_sigma = 0;
  constexpr int kSeeds = 100;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const SensorImage measured = LidarDepth(exact, camera, seed);
    for (std::size_t i = 0; i < exact.depth_m.size(); ++i) {
      const double error = 1. / measured.depth_m[i] - 1. / exact.depth_m[i];
      sum += std::pow(error / measured.inverse_depth_sigma[i], 2);
      ++count;
    }
    frame_sigma = measured.inverse_depth_sigma(32, 24);
  }
  // At least one independent value per 25 dots. 23 for each of the 100 images. The noise of the
  // dots is computed at the exact range.
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2. / (kSeeds * 23)));
  // The fit averages several dots.
  const LidarOptions options;
  EXPECT_LT(frame_sigma, options.noise.Sigma(2, std::cos(0.4)) / 4);
}

// Pixels between the surfaces. They are fewer if the colours differ.
double BlurredRatio(const SensorImage& image, double near_m, double far_m) {
  double blurred = 0;
  for (const float z : image.depth_m) blurred += z > 1.1 * near_m && z < 0.9 * far_m;
  return blurred / static_cast<double>(image.depth_m.size());
}

TEST(Lidar, ColorGuidesDepthEdges) {
  const LidarOptions options = ExactDots();
  const auto blurred = [&](Rgb8 near_color) {
    const Rendering exact = StepView(PhoneCamera(), 1, 2, 80, 180, near_color, kWhite);
    return BlurredRatio(LidarDepth(exact, PhoneCamera(), 1, options), 1, 2);
  };
  // Two edges. Without a colour difference they are blurred over half a spacing of 10.7 px or more.
  EXPECT_GT(blurred(kWhite), 2 * 5. / 256);
  EXPECT_LT(blurred({60, 60, 200}), 0.2 * blurred(kWhite));
}

TEST(Lidar, ConfidenceIsLowAtEdgesAndForDarkAndFarSurfaces) {
  LidarOptions options;
  options.edge_px = 3;
  const auto confidence = [&](const Rendering& exact) {
    return LidarDepth(exact, PhoneCamera(), 1, options).confidence;
  };
  const Image<std::uint8_t> step = confidence(StepView(PhoneCamera(), 1, 1.5, 100, 200));
  for (const auto [u, v] : Pixels(80, 220, 0, 192)) {
    // Distance to the nearest pixel of the other surface.
    const int left = u < 100 ? 100 - u : u - 99, right = u < 200 ? 200 - u : u - 199;
    const int distance = std::min(left, right);
    ASSERT_EQ(step(u, v), distance <= 3 ? 0 : distance <= 6 ? 1 : 2) << u << " " << v;
  }
  const auto middle = [&](double z, std::uint8_t value) -> int {
    const auto color = [&](int, int) { return Rgb8{value, value, value}; };
    return confidence(PlaneView(PhoneCamera(), z, 0, color))(128, 96);
  };
  int last = 2;
  for (const double z : {0.5, 1., 2., 3., 4., 6., 8., 12.}) {  // white surfaces
    const double sigma = options.noise.Sigma(z, 1);
    const int expected = sigma > options.medium_sigma_m ? 0 : sigma > options.high_sigma_m ? 1 : 2;
    EXPECT_EQ(middle(z, 255), expected) << z;
    EXPECT_LE(expected, last);
    last = expected;
  }
  EXPECT_EQ(middle(1, 255), 2);
  EXPECT_EQ(last, 0);
  EXPECT_EQ(middle(2, 20), 0);  // reflectance 0.007
}

TEST(Lidar, WithoutADotThereIsNoDepth) {
  const Rendering empty = ViewOf(PhoneCamera(), [](int, int) { return SurfacePoint{}; });
  const SensorImage measured = LidarDepth(empty, PhoneCamera(), 1);
  EXPECT_EQ(MissingRatio(measured), 1);
  EXPECT_THAT(measured.confidence, Each(0));
}

// Only one dot is on the surface: it fills the image.
TEST(Lidar, FillsFarFromTheNearestDot) {
  Rendering exact = PlaneView(PhoneCamera(), 2);
  for (const auto [u, v] : PixelsOf(PhoneCamera())) {
    if (u > 8 || v > 6) exact.depth_m(u, v) = 0;
  }
  const SensorImage measured = LidarDepth(exact, PhoneCamera(), 1, ExactDots());
  for (const auto [u, v] : PixelsOf(PhoneCamera())) {
    ASSERT_NEAR(measured.depth_m(u, v), 2, 1e-4);
    if (u > 8 || v > 6) {
      ASSERT_EQ(measured.confidence(u, v), 0);
    }
  }
}

TEST(Lidar, DependsOnSeedAndNotOnThreads) {
  const Rendering exact = StepView(PhoneCamera(), 1, 2, 100, 200);
  const auto images = AtThreads({1, 2, 5}, [&] { return LidarDepth(exact, PhoneCamera(), 7); });
  for (const SensorImage& image : images) {
    EXPECT_TRUE(images[0].depth_m == image.depth_m);
    EXPECT_TRUE(images[0].confidence == image.confidence);
  }
  EXPECT_FALSE(images[0].depth_m == LidarDepth(exact, PhoneCamera(), 8).depth_m);
}

TEST(Lidar, RejectsBadOptions) {
  LidarOptions options;
  options.medium_sigma_m = 0.001;
  ExpectInputError([&] { LidarDepth(PlaneView(PhoneCamera(), 1), PhoneCamera(), 1, options); },
                   HasSubstr("medium_sigma_m is 0.001, must not be below high_sigma_m"));
}

}  // namespace
}  // namespace surfit::testing
