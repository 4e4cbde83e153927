#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "simulation/sensor_views.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

// No noise, no bleeding and no loss at edges.
StereoOptions PlainStereo() {
  StereoOptions options;
  options.disparity_sd_px = options.window_px = options.edge_loss = 0;
  return options;
}

// Depth is a float: 2^-24 relative, twice.
constexpr double kFloat = 1.2e-7;

TEST(Stereo, NoiseOfPlanesIsConstantInInverseDepth) {
  const StereoOptions options;
  for (const double z : {0.8, 1.6, 3.2}) {
    const Rendering exact = PlaneView(SensorCamera(), z, 0.3, Squares);
    std::vector<double> errors;
    for (int seed = 0; seed < 12; ++seed) {
      const SensorImage measured = StereoDepth(exact, SensorCamera(), seed, options);
      EXPECT_EQ(MissingRatio(measured), 0) << z;
      for (const double e : InverseDepthErrors(exact, measured)) errors.push_back(e);
      EXPECT_FLOAT_EQ(measured.inverse_depth_sigma(7, 9),
                      static_cast<float>(options.InverseDepthSigma()));
    }
    // Squared errors have the correlation exp(-2 r^2 / L^2), so one independent value has the area
    // pi L^2 / 2 = 157 px, and the mean one of pi L^2 = 314 px.
    const Spread spread = SpreadOf(errors);
    const double sigma = options.InverseDepthSigma(), count = spread.count;
    EXPECT_NEAR(spread.sd, sigma, 4 * sigma / std::sqrt(2 * count / 157)) << z;
    EXPECT_NEAR(spread.mean, 0, 4 * sigma / std::sqrt(count / 314)) << z;
  }
}

TEST(Stereo, NoiseHasTheCorrelationLength) {
  const Rendering exact = PlaneView(SensorCamera(), 1, 0, Squares);
  for (const double length_px : {10., 5.}) {
    StereoOptions options;
    options.correlation_px = length_px;
    double sum[4] = {}, squares = 0;
    const int gaps[4] = {2, 5, 10, 30};
    for (int seed = 0; seed < 12; ++seed) {
      const SensorImage measured = StereoDepth(exact, SensorCamera(), seed, options);
      const auto error = [&](int u, int v) {
        return 1. / measured.depth_m(u, v) - 1. / exact.depth_m(u, v);
      };
      for (const auto [u, v] : Pixels(0, 290, 0, 210)) {
        squares += 2 * error(u, v) * error(u, v);
        for (int k = 0; k < 4; ++k) {
          sum[k] += error(u, v) * (error(u + gaps[k], v) + error(u, v + gaps[k]));
        }
      }
    }
    for (int k = 0; k < 4; ++k) {
      // There are 12 * 60900 / 157 = 4600 independent products, or more. Four standard errors.
      EXPECT_NEAR(sum[k] / squares, std::exp(-std::pow(gaps[k] / length_px, 2)),
                  4 / std::sqrt(4600.))
          << gaps[k];
    }
  }
}

TEST(Stereo, OccludesTheBackgroundBesideTheLeftEdge) {
  const Rendering exact = StepView(SensorCamera(), 1, 3, 100, 200);
  const SensorImage measured = StereoDepth(exact, SensorCamera(), 1, PlainStereo());
  // 0.05 m * 262.5 px * (1 / 1 m - 1 / 3 m) = 8.75 px: the pixels 92 ... 99, and 91 in part.
  for (const auto [u, v] : PixelsOf(SensorCamera())) {
    if (u == 91) continue;
    const double z = u >= 92 && u < 100 ? 0 : exact.depth_m(u, v);
    ASSERT_NEAR(measured.depth_m(u, v), z, kFloat * z) << u << " " << v;
  }
}

// With a window of 4 px, a pixel at k px from the edge bleeds if 4 x > k for a uniform x: with the
// probability 1 - k / 4.
TEST(Stereo, NearSurfaceBleedsIntoTheBackground) {
  StereoOptions options = PlainStereo();
  options.window_px = 4;
  const Rendering exact = StepView(SensorCamera(), 1, 3, 100, 200);
  double bled[6] = {}, pixels = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const SensorImage measured = StereoDepth(exact, SensorCamera(), seed, options);
    for (int v = 0; v < 240; ++v, ++pixels) {
      for (int k = 0; k < 6; ++k) {
        const float z = measured.depth_m(199 + k, v);
        EXPECT_TRUE(z == 1 || std::abs(z - 3) < 3 * kFloat) << z;
        bled[k] += z == 1;
      }
    }
  }
  EXPECT_EQ(bled[0], pixels);  // on the near surface
  EXPECT_EQ(bled[4] + bled[5], 0);
  for (int k = 1; k < 4; ++k) {
    // One independent value has the length sqrt(pi) L = 18 px along the edge. The edge has 266
    // independent values.
    EXPECT_NEAR(bled[k] / pixels, 1 - k / 4., 4 * std::sqrt(0.25 / 266)) << k;
  }
}

TEST(Stereo, LosesARatioOfPixelsNearEdges) {
  StereoOptions options = PlainStereo();
  options.window_px = 4;
  options.edge_loss = 0.35;
  const Rendering exact = StepView(SensorCamera(), 1, 3, 100, 200);
  double missing = 0, pixels = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const SensorImage measured = StereoDepth(exact, SensorCamera(), seed, options);
    for (const auto [u, v] : Pixels(196, 204, 0, 240)) {
      ++pixels;
      missing += measured.depth_m(u, v) == 0;
    }
    for (const auto [u, v] : Pixels(204, 320, 0, 240)) ASSERT_GT(measured.depth_m(u, v), 0);
  }
  EXPECT_NEAR(missing / pixels, 0.35, 4 * std::sqrt(0.35 * 0.65 / 266));
}

// White at z has the projected contrast 0.2 / z^2 on the optical axis. It is 0.005 at 6.32 m.
TEST(Stereo, NeedsTextureBeyondTheReachOfTheProjector) {
  const PinholeCamera camera = SensorCamera();
  const auto missing = [&](double z, const std::function<Rgb8(int, int)>& color) {
    StereoOptions options;
    options.min_contrast_sd = 0;
    return StereoDepth(PlaneView(camera, z, 0, color), camera, 1, options).depth_m(160, 120) == 0;
  };
  const auto gray = [](int, int) { return Rgb8{128, 128, 128}; };  // reflectance 0.216
  EXPECT_FALSE(missing(6.2, {}));
  EXPECT_TRUE(missing(6.4, {}));
  EXPECT_FALSE(missing(6.4, Squares));
  EXPECT_FALSE(missing(2.9, gray));  // 6.32 m * sqrt(0.216) = 2.94 m
  EXPECT_TRUE(missing(3.0, gray));
}

// The contrast at z is 0.2 / z^2, so a pixel is missing if log(0.2 / (0.005 z^2)) is smaller than
// the normal value of the pixel times 0.2. At 0.2 below log(0.2 / 0.005) that are 84.1 %.
TEST(Stereo, ReachOfTheProjectorVariesInTheImage) {
  const PinholeCamera camera = {320,   240,   5000, 5000,
                                159.5, 119.5, {}};  // same contrast everywhere
  const double z = std::sqrt(0.2 / (0.005 * std::exp(-0.2)));
  double missing = 0;
  for (int seed = 0; seed < 10; ++seed) {
    missing += MissingRatio(StereoDepth(PlaneView(camera, z), camera, seed)) / 10;
  }
  EXPECT_NEAR(missing, 0.841, 4 * std::sqrt(0.841 * 0.159 / (10 * 320 * 240 / 314.)) + 0.002);
}

TEST(Stereo, IsMissingBeyondTheLargestIncidenceAndDepth) {
  const PinholeCamera camera = SensorCamera();
  const auto missing = [&](double z, double slant_deg) {
    StereoOptions options = PlainStereo();
    options.window_px = 2;  // sees the squares
    const Rendering exact = PlaneView(camera, z, slant_deg * M_PI / 180, Squares);
    return StereoDepth(exact, camera, 1, options).depth_m(160, 120) == 0;
  };
  EXPECT_FALSE(missing(1, 77));
  EXPECT_TRUE(missing(1, 79));
  EXPECT_FALSE(missing(0.29, 0));
  EXPECT_TRUE(missing(0.27, 0));
  EXPECT_FALSE(missing(9.9, 0));
  EXPECT_TRUE(missing(10.1, 0));
}

TEST(Stereo, DependsOnSeedAndNotOnThreads) {
  const Rendering exact = StepView(SensorCamera(), 1, 2, 100, 200);
  const auto images =
      AtThreads({1, 2, 5}, [&] { return StereoDepth(exact, SensorCamera(), 7).depth_m; });
  EXPECT_TRUE(images[0] == images[1]);
  EXPECT_TRUE(images[0] == images[2]);
  EXPECT_FALSE(images[0] == StereoDepth(exact, SensorCamera(), 8).depth_m);
}

TEST(Stereo, KeepsMissingPixelsMissing) {
  Rendering exact = PlaneView(SensorCamera(), 1);
  exact.depth_m(100, 100) = 0;
  const SensorImage measured = StereoDepth(exact, SensorCamera(), 1);
  EXPECT_EQ(measured.depth_m(100, 100), 0);
  EXPECT_EQ(measured.inverse_depth_sigma(100, 100), 0);
  EXPECT_TRUE(measured.confidence.empty());
}

TEST(Stereo, RejectsBadOptions) {
  StereoOptions options;
  options.baseline_m = 0;
  ExpectInputError([&] { StereoDepth(PlaneView(SensorCamera(), 1), SensorCamera(), 1, options); },
                   HasSubstr("baseline_m is 0"));
  options = {};
  options.max_depth_m = 0.1;
  ExpectInputError([&] { StereoDepth(PlaneView(SensorCamera(), 1), SensorCamera(), 1, options); },
                   HasSubstr("max_depth_m is 0.1, must be above min_depth_m"));
}

}  // namespace
}  // namespace surfit::testing
