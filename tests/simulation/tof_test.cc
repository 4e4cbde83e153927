#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "simulation/sensor_views.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

constexpr double kNear_m = 1, kFar_m = 2;
constexpr Rgb8 kGray = {128, 128, 128};
constexpr double kGrayReflectance = 0.2158605;  // ((128 / 255 + 0.055) / 1.055)^2.4

TofOptions PlainTof() {
  TofOptions options;
  options.noise = {0, 0, 0};
  options.multipath_gain = options.flying_ratio = 0;
  return options;
}

TEST(RangeNoise, IsTheShotNoiseOfSignalAndAmbientLight) {
  const RangeNoise noise = {0.003, 0.002, 0.5};
  // Signal 1: 9 + 4 * 1.5 = 15 mm^2. Signal 0.5 / 4 = 0.125: 9 + 4 * 0.625 * 64 = 169 mm^2.
  EXPECT_NEAR(noise.Sigma(1, 1), std::sqrt(15.) / 1000, 1e-12);
  EXPECT_NEAR(noise.Sigma(2, 0.5), 0.013, 1e-12);
  EXPECT_GT(noise.Sigma(1, 0), 1e9);
}

TEST(Tof, NoiseGrowsWithDistanceAndLowReflectance) {
  TofOptions options;
  const PinholeCamera camera = SensorCamera();
  for (const double z : {0.7, 1.5, 3.}) {
    for (const auto& [color, reflectance] :
         {std::pair{kWhite, 1.}, std::pair{kGray, kGrayReflectance}}) {
      const Rendering exact = PlaneView(camera, z, 0, [c = color](int, int) { return c; });
      const SensorImage measured = TofDepth(exact, camera, 1, options);
      std::vector<double> normalised, products;
      for (const auto [u, v] : PixelsOf(camera)) {
        ASSERT_GT(measured.depth_m(u, v), 0);
        // On a frontal plane cos(incidence) is 1 / |ray|, and the range z |ray|.
        const double ray = camera.Ray(u, v).norm(), range = z * ray;
        const double signal = reflectance / ray / (range * range);
        const double sigma = std::sqrt(0.0005 * 0.0005 * (1 + (signal + 0.01) / (signal * signal)));
        normalised.push_back((measured.depth_m(u, v) - z) * ray / sigma);
        EXPECT_NEAR(measured.inverse_depth_sigma(u, v), sigma / ray / (z * z),
                    0.05 * sigma / ray / (z * z));  // it is divided by the measured depth
        if (u > 0) products.push_back(normalised.back() * normalised[normalised.size() - 2]);
      }
      const double count = normalised.size();
      EXPECT_NEAR(SpreadOf(normalised).sd, 1, 4 / std::sqrt(2 * count)) << z;
      EXPECT_NEAR(SpreadOf(normalised).mean, 0, 4 / std::sqrt(count)) << z;
      EXPECT_NEAR(SpreadOf(products).mean, 0, 4 / std::sqrt(count)) << z;  // no correlation
    }
  }
}

TEST(Tof, LosesDarkAndFarPixels) {
  const PinholeCamera camera = SensorCamera();
  const auto missing = [&](double z, std::uint8_t value) {
    const auto color = [&](int, int) { return Rgb8{value, value, value}; };
    return TofDepth(PlaneView(camera, z, 0, color), camera, 1).depth_m(160, 120) == 0;
  };
  EXPECT_TRUE(missing(0.48, 255));
  EXPECT_FALSE(missing(0.52, 255));
  EXPECT_FALSE(missing(5.4, 255));
  EXPECT_TRUE(missing(5.5, 255));
  EXPECT_FALSE(missing(1, 30));  // reflectance 0.013
  EXPECT_TRUE(missing(3, 30));   // signal 0.0014: 37 mm
}

TEST(Tof, MultipathMakesConcaveCornersFarther) {
  const PinholeCamera camera = SensorCamera();
  TofOptions options = PlainTof();
  options.multipath_gain = 1;
  const auto biases = [&](const Rendering& exact) {
    const SensorImage measured = TofDepth(exact, camera, 1, options);
    std::vector<double> differences;
    for (std::size_t i = 0; i < exact.depth_m.size(); ++i) {
      differences.push_back(measured.depth_m[i] - static_cast<double>(exact.depth_m[i]));
    }
    return differences;
  };
  const auto concave = biases(CornerView(camera, 2, true));
  const auto dark = biases(CornerView(camera, 2, true, kGray));
  for (std::size_t i = 0; i < concave.size(); ++i) {
    ASSERT_GT(concave[i], -1e-6);
    ASSERT_LT(concave[i], 0.05);
    // The irradiance is 0.22 of that of white.
    ASSERT_LT(dark[i], 0.5 * concave[i] + 1e-6);
  }
  // The walls meet between the columns 159 and 160.
  for (int v = 60; v < 180; ++v) {
    for (const int u : {140, 180}) EXPECT_GT(concave[v * camera.width + u], 0.003) << u << " " << v;
  }
  for (const Rendering& exact : {CornerView(camera, 1, false), PlaneView(camera, 2, 0.5)}) {
    for (const double bias : biases(exact)) ASSERT_NEAR(bias, 0, 1e-6);
  }
  options.multipath_gain = 0;
  for (const double bias : biases(CornerView(camera, 2, true))) ASSERT_NEAR(bias, 0, 1e-6);
}

// Sums the same integral over every pixel of the image instead of patches of 13 x 13 pixels.
TEST(Tof, MultipathIsTheIntegralOverTheVisibleSurface) {
  const PinholeCamera camera = SensorCamera();
  const Rendering exact = CornerView(camera, 2, true);
  TofOptions options = PlainTof();
  options.multipath_gain = 1;
  const SensorImage measured = TofDepth(exact, camera, 1, options);
  const auto point = [&](int u, int v) -> Vector3d {
    return exact.depth_m(u, v) * camera.Ray(u, v);
  };
  for (const auto& [u, v] : {std::pair{180, 120}, {220, 60}, {100, 200}, {174, 30}}) {
    const Vector3d x = point(u, v), n = exact.normal(u, v).cast<double>();
    double share = 0, sum = 0;
    for (const auto [other_u, other_v] : PixelsOf(camera)) {
      const Vector3d y = point(other_u, other_v), m = exact.normal(other_u, other_v).cast<double>();
      const Vector3d way = y - x;
      if (!(n.dot(way) > 1e-6)) continue;  // on the same wall
      const double length = way.norm(), ray = camera.Ray(other_u, other_v).norm();
      const double solid_angle = 1 / (camera.fx * camera.fy * ray * ray * ray);
      const double excess = (y.norm() + length - x.norm()) / 2,
                   reach = 299792458 / (4 * M_PI * 2e8);
      const double irradiance = solid_angle * n.dot(way) * -m.dot(way) /
                                (M_PI * std::pow(length, 4)) *
                                std::exp(-std::pow(excess / reach, 2) / 2);
      const double ratio = irradiance * x.squaredNorm() / (-n.dot(x) / x.norm());
      share += ratio;
      sum += ratio * excess;
    }
    const double bias = sum / (1 + share) / camera.Ray(u, v).norm();
    EXPECT_NEAR(measured.depth_m(u, v) - exact.depth_m(u, v), bias, 0.1 * bias) << u << " " << v;
  }
}

TEST(Tof, ARatioOfEdgePixelsFliesBetweenTheSurfaces) {
  TofOptions options = PlainTof();
  options.flying_ratio = 0.4;
  const Rendering exact = StepView(SensorCamera(), kNear_m, kFar_m, 100, 200);
  double flying = 0, pixels = 0, beyond_middle = 0, edge_flying = 0;
  for (int seed = 0; seed < 10; ++seed) {
    const SensorImage measured = TofDepth(exact, SensorCamera(), seed, options);
    for (const auto [u, v] : PixelsOf(SensorCamera())) {
      const double z = measured.depth_m(u, v), truth = exact.depth_m(u, v);
      const bool is_beside_edge = u == 99 || u == 100 || u == 199 || u == 200;
      if (!is_beside_edge) {
        ASSERT_NEAR(z, truth, 1e-6) << u << " " << v;
        continue;
      }
      ++pixels;
      // The ray of the neighbour is longer or shorter by 0.06 % at most.
      ASSERT_GE(z, kNear_m - 0.002);
      ASSERT_LE(z, kFar_m + 0.002);
      if (std::abs(z - truth) < 1e-6) continue;
      ++flying;
      // The signal of the near surface is 4 times larger. A pixel of the far surface is therefore
      // nearer than the middle if the near surface has more than 1 / 5 of its area.
      if (truth != kFar_m) continue;
      ++edge_flying;
      beyond_middle += z < (kNear_m + kFar_m) / 2;
    }
  }
  EXPECT_NEAR(flying / pixels, 0.4, 4 * std::sqrt(0.24 / pixels));
  EXPECT_NEAR(beyond_middle / edge_flying, 0.8, 4 * std::sqrt(0.16 / edge_flying) + 0.005);
}

TEST(Tof, DependsOnSeedAndNotOnThreads) {
  const Rendering exact = CornerView(SensorCamera(), 2, true);
  const auto images =
      AtThreads({1, 2, 5}, [&] { return TofDepth(exact, SensorCamera(), 7).depth_m; });
  EXPECT_TRUE(images[0] == images[1]);
  EXPECT_TRUE(images[0] == images[2]);
  EXPECT_FALSE(images[0] == TofDepth(exact, SensorCamera(), 8).depth_m);
}

TEST(Tof, KeepsMissingPixelsMissing) {
  Rendering exact = PlaneView(SensorCamera(), 1);
  exact.depth_m(100, 100) = 0;
  const SensorImage measured = TofDepth(exact, SensorCamera(), 1);
  EXPECT_EQ(measured.depth_m(100, 100), 0);
  EXPECT_EQ(measured.inverse_depth_sigma(100, 100), 0);
}

TEST(Tof, RejectsBadOptions) {
  TofOptions options;
  options.flying_ratio = 1.5;
  ExpectInputError([&] { TofDepth(PlaneView(SensorCamera(), 1), SensorCamera(), 1, options); },
                   HasSubstr("flying_ratio is 1.5"));
  options = {};
  options.noise.shot_m = -1;
  ExpectInputError([&] { TofDepth(PlaneView(SensorCamera(), 1), SensorCamera(), 1, options); },
                   HasSubstr("shot_m is -1"));
}

}  // namespace
}  // namespace surfit::testing
