#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "frame/plane_images.h"
#include "surfit/frame/preprocess.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

// The result of the filter is a weighted mean of inverse depths r. Two roundings (z, 1/z) change
// each r, and four change a difference d, relative to r. An error e of all d changes the mean of (1
// - d^2/c^2)^2 d by less than 10 e. The derivative of weight times d is at most 1. The derivative
// of the weight adds at most 4 x^2 (1 - x^2) <= 1 per tap, and once more through the denominator.
// Taps near the cut-off have at most 5 times the weight of the other taps.
constexpr double kRelativeTolerance = 10 * 4 * kFloatRounding;

// Definition of the filter, in double precision.
double FilteredInverseDepth(const Image<float>& depth_m, int u, int v,
                            const PreprocessOptions& options) {
  const int radius = options.filter_radius_px;
  const double cutoff = options.filter_cutoff * DepthNoise().inverse_depth_sigma;
  const double center = 1.0 / depth_m(u, v);
  double sum = 0, weight_sum = 0;
  for (int y = std::max(0, v - radius); y <= std::min(depth_m.height() - 1, v + radius); ++y) {
    for (int x = std::max(0, u - radius); x <= std::min(depth_m.width() - 1, u + radius); ++x) {
      if (depth_m(x, y) == 0) continue;
      const double inverse = 1.0 / depth_m(x, y);
      const double share = std::min(1.0, std::abs(inverse - center) / cutoff);
      const double weight = std::pow(1 - share * share, 2) *
                            (1 - std::abs(x - u) / (radius + 1.0)) *
                            (1 - std::abs(y - v) / (radius + 1.0));
      sum += weight * inverse;
      weight_sum += weight;
    }
  }
  return sum / weight_sum;
}

// Slanted surface with sensor noise, steps and holes.
Image<float> RoughDepth(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> noise(0, DepthNoise().inverse_depth_sigma);
  std::uniform_int_distribution<int> dice(0, 9);
  Image<float> depth_m(61, 43);
  for (const auto [u, v] : PixelsOf(depth_m)) {
    const double step = (u + v) % 17 > 11 ? 0.1 : 0;
    const double inverse = 0.4 + 0.001 * u + step + noise(rng);
    depth_m(u, v) = dice(rng) == 0 ? 0.f : static_cast<float>(1 / inverse);
  }
  return depth_m;
}

TEST(FilterDepth, AgreesWithDefinitionInDoublePrecision) {
  const Image<float> depth_m = RoughDepth(3);
  for (const int radius : {1, 2, 4}) {
    PreprocessOptions options;
    options.filter_radius_px = radius;
    const Image<float> filtered = FilterDepth(depth_m, DepthNoise(), options);
    for (const auto [u, v] : PixelsOf(depth_m)) {
      if (depth_m(u, v) == 0) continue;
      const double expected = 1 / FilteredInverseDepth(depth_m, u, v, options);
      ASSERT_NEAR(filtered(u, v), expected, kRelativeTolerance * expected)
          << radius << " px, at " << u << ", " << v;
    }
  }
}

TEST(FilterDepth, KeepsValidAndMissingPixels) {
  const Image<float> depth_m = RoughDepth(4);
  const Image<float> filtered = FilterDepth(depth_m, DepthNoise(), PreprocessOptions());
  ASSERT_EQ(filtered.width(), depth_m.width());
  ASSERT_EQ(filtered.height(), depth_m.height());
  for (std::size_t i = 0; i < depth_m.size(); ++i) EXPECT_EQ(filtered[i] > 0, depth_m[i] > 0) << i;
}

TEST(FilterDepth, KeepsImagesWithoutDepth) {
  EXPECT_TRUE(FilterDepth(Image<float>(), DepthNoise(), PreprocessOptions()).empty());
  const Image<float> missing(50, 40, 0.f);
  EXPECT_TRUE(FilterDepth(missing, DepthNoise(), PreprocessOptions()) == missing);
}

TEST(FilterDepth, RadiusZeroKeepsDepth) {
  PreprocessOptions options;
  options.filter_radius_px = 0;
  const Image<float> depth_m = RoughDepth(5);
  EXPECT_TRUE(FilterDepth(depth_m, DepthNoise(), options) == depth_m);
}

TEST(FilterDepth, KeepsDepthOfIsolatedPixels) {
  Image<float> depth_m(20, 20, 0.f);
  depth_m(0, 0) = 1.2345f;
  depth_m(10, 10) = 2.3456f;
  const Image<float> filtered = FilterDepth(depth_m, DepthNoise(), PreprocessOptions());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    EXPECT_NEAR(filtered[i], depth_m[i], 2 * kFloatRounding * depth_m[i]);  // 1 / (1 / z)
  }
}

// A plane is linear in inverse depth, and opposite pixels have equal weights. So the filter does
// not change a plane inside the image, at any slant.
TEST(FilterDepth, KeepsPlanes) {
  const PinholeCamera camera = SmallCamera();
  const PreprocessOptions options;
  const int radius = options.filter_radius_px;
  for (const Plane& plane : ManyPlanes()) {
    const Image<float> depth_m = PlaneDepth(plane, camera);
    const Image<float> filtered = FilterDepth(depth_m, DepthNoise(), options);
    int compared = 0;
    for (const auto [u, v] :
         Pixels(radius, camera.width - radius, radius, camera.height - radius)) {
      bool whole = true;
      for (const int dv : {-radius, radius}) {
        for (const int du : {-radius, radius}) whole &= depth_m(u + du, v + dv) > 0;
      }
      if (!whole) continue;
      ++compared;
      ASSERT_NEAR(filtered(u, v), depth_m(u, v), kRelativeTolerance * depth_m(u, v));
    }
    EXPECT_GT(compared, 2000);
  }
}

// If the noise is small relative to the cut-off, the filter is a mean with triangular weights. The
// remaining ratio of the variance is sum w^2 / (sum w)^2: ((1 + 4 + 9 + 4 + 1) / 9^2)^2 at a radius
// of 2.
TEST(FilterDepth, ReducesVarianceByItsWeights) {
  PreprocessOptions options;
  const double sigma = 0.05 * DepthNoise().inverse_depth_sigma;
  std::mt19937_64 rng(7);
  std::normal_distribution<double> noise(0, sigma);
  Image<float> depth_m(500, 500);
  for (float& z : depth_m) z = static_cast<float>(1 / (1 + noise(rng)));
  const Image<float> filtered = FilterDepth(depth_m, DepthNoise(), options);
  double square_sum = 0;
  int count = 0;
  for (int v = 5; v < 495; v += 5) {  // 5 px apart: no shared pixels
    for (int u = 5; u < 495; u += 5, ++count) square_sum += std::pow(1 / filtered(u, v) - 1, 2);
  }
  const double expected = std::pow(19.0 / 81, 2) * sigma * sigma;
  // A variance of N samples has the relative standard deviation sqrt(2 / N). Differences of sqrt(2)
  // * 0.05 sigma reduce a weight by at most 2 * (0.07 / 4)^2 = 0.06 %.
  EXPECT_NEAR(square_sum / count, expected, (4 * std::sqrt(2.0 / count) + 1e-3) * expected);
}

// Pixels beyond a step larger than the cut-off have no weight. So each side is bitwise identical to
// the result without the other side.
TEST(FilterDepth, DoesNotMixSidesOfStep) {
  const PreprocessOptions options;
  const double step = 1.5 * options.filter_cutoff * DepthNoise().inverse_depth_sigma;
  std::mt19937_64 rng(9);
  std::uniform_real_distribution<double> noise(-step / 8, step / 8);
  Image<float> near_side(40, 30, 0.f), far_side(40, 30, 0.f), both(40, 30);
  for (const auto [u, v] : PixelsOf(40, 30)) {
    const bool is_near = u + v / 3 < 20;
    const double inverse = 0.5 + (is_near ? step : 0) + noise(rng);
    both(u, v) = static_cast<float>(1 / inverse);
    (is_near ? near_side : far_side)(u, v) = both(u, v);
  }
  const Image<float> filtered = FilterDepth(both, DepthNoise(), options);
  const Image<float> filtered_near = FilterDepth(near_side, DepthNoise(), options);
  const Image<float> filtered_far = FilterDepth(far_side, DepthNoise(), options);
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_EQ(filtered[i], filtered_near[i] + filtered_far[i]) << i;  // one of the two is 0
  }
}

}  // namespace
}  // namespace surfit::testing
