#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <random>

#include "frame/plane_images.h"
#include "surfit/frame/preprocess.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

TEST(VertexMap, VerticesAreOnRaysOfTheirPixels) {
  const PinholeCamera camera = SmallCamera();
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<float> depth(0.3f, 8.f);
  Image<float> depth_m(camera.width, camera.height);
  for (float& z : depth_m) z = depth(rng);
  const VectorImage vertex = VertexMap(depth_m, camera);
  ASSERT_EQ(vertex.width(), camera.width);
  ASSERT_EQ(vertex.height(), camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    const double z = depth_m(u, v);
    EXPECT_EQ(vertex.z(u, v), depth_m(u, v));
    // (u - cx) / fx < 1: cx, the difference, 1 / fx and two products are rounded.
    const Eigen::Vector3d point = vertex(u, v).cast<double>();
    EXPECT_LT((point - z * camera.Ray(u, v)).norm(), 6 * kFloatRounding * z);
    const Eigen::Vector2d pixel = camera.Project(point);
    EXPECT_LT((pixel - Eigen::Vector2d(u, v)).norm(), 6 * kFloatRounding * camera.fx);
  }
}

TEST(VertexMap, IsZeroWithoutDepth) {
  Image<float> depth_m(9, 7, 0.f);
  depth_m(4, 3) = 2.f;
  const VectorImage vertex = VertexMap(depth_m, SmallCamera());
  for (const auto [u, v] : PixelsOf(9, 7)) EXPECT_EQ(vertex(u, v).isZero(0.f), u != 4 || v != 3);
}

VectorImage Normals(const Image<float>& depth_m, const PinholeCamera& camera,
                    const PreprocessOptions& options = {}, const DepthNoise& noise = {}) {
  return NormalMap(VertexMap(depth_m, camera), {camera, noise}, options);
}

// Error of a normal. Inverse depth has two roundings, and a slope at most the same error, because
// it is one or more symmetric differences. The error of the vector (f r_u, f r_v, ...) is at most
// sqrt(2) f, plus the same in its third component. The sum is at most 3 f, because |u - cx| < f.
// The length of the vector is at least r / |ray|.
double NormalTolerance(const PinholeCamera& camera) {
  return 3 * camera.fx * 2 * kFloatRounding * kLongestRay;
}

TEST(NormalMap, IsExactOnPlanes) {
  const PinholeCamera camera = SmallCamera();
  for (const Plane& plane : ManyPlanes()) {
    const Image<float> depth_m = PlaneDepth(plane, camera);
    const VectorImage normal = Normals(depth_m, camera);
    int seen = 0;
    for (const auto [u, v] : Pixels(1, camera.width - 1, 1, camera.height - 1)) {
      if (depth_m(u, v) == 0 || plane.Slant(camera.Ray(u, v)) > 1.3) continue;
      ++seen;
      ASSERT_THAT(normal(u, v).cast<double>(), VectorNear(plane.normal, NormalTolerance(camera)))
          << u << ", " << v;
    }
    EXPECT_GT(seen, 1000);
  }
}

// Pixels steeper than max_slant_rad along the image axes have no normal.
TEST(NormalMap, IsZeroOnSteepSurface) {
  const PinholeCamera camera = SmallCamera();
  PreprocessOptions options;
  options.max_slant_rad = 0.9;
  const DepthNoise no_slack = {1e-9};
  for (const double tilt_rad : {0.85, 0.95}) {
    const Plane plane = TiltedPlane(tilt_rad, 0);
    const VectorImage normal = Normals(PlaneDepth(plane, camera), camera, options, no_slack);
    // On the optical axis dr/du / r = tan(tilt) / f: the tilt to the ray is the tilt of the plane.
    const int u = 48, v = 35;
    ASSERT_NEAR(plane.Slant(camera.Ray(u, v)), tilt_rad, 0.01);
    EXPECT_EQ(normal(u, v).isZero(0.f), tilt_rad > 0.9);
  }
}

Image<float> RoughDepth(const PinholeCamera& camera) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> noise(0, 0.001);
  std::uniform_int_distribution<int> dice(0, 60);
  Image<float> depth_m(camera.width, camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    const double inverse = 0.5 + 0.004 * u - 0.002 * v + (u + 2 * v > 130 ? 0.5 : 0) + noise(rng);
    depth_m(u, v) = dice(rng) == 0 ? 0.f : static_cast<float>(1 / inverse);
  }
  return depth_m;
}

// Slope along a direction, by definition: a line fitted to the longest run of offsets on both sides
// that continue the surface. Returns std::nullopt without such an offset. Sets `close` if a value
// is too close to the bound for single precision.
std::optional<double> FittedSlope(const Image<float>& depth_m, int u, int v, int du, int dv,
                                  double focal, const PreprocessOptions& options, bool* close) {
  const auto inverse = [&](int k) {
    const int x = u + k * du, y = v + k * dv;
    const bool inside = x >= 0 && y >= 0 && x < depth_m.width() && y < depth_m.height();
    return inside && depth_m(x, y) > 0 ? 1.0 / depth_m(x, y) : 0.0;
  };
  const double bound =
      3 * DepthNoise().inverse_depth_sigma + std::tan(options.max_slant_rad) / focal * inverse(0);
  int run = 0;
  for (int k = 1; k <= options.normal_radius_px && run == k - 1; ++k) {
    bool continues = true;
    for (const int sign : {-1, 1}) {
      const double step = std::abs(inverse(sign * k) - inverse(sign * (k - 1)));
      continues &= inverse(sign * k) > 0 && step < bound;
      *close |= std::abs(step - bound) < 1e-5;
    }
    if (continues) run = k;
  }
  if (run == 0) return std::nullopt;
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (int k = -run; k <= run; ++k) {
    n += 1, x += k, y += inverse(k), xx += k * k, xy += k * inverse(k);
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

TEST(NormalMap, AgreesWithLineFitsInDoublePrecision) {
  const PinholeCamera camera = SmallCamera();
  const Image<float> depth_m = RoughDepth(camera);
  PreprocessOptions options;
  options.max_slant_rad = 1.3;
  for (const int radius : {1, 2, 5}) {
    options.normal_radius_px = radius;
    const VectorImage normal = Normals(depth_m, camera, options);
    std::array<int, 2> seen = {0, 0};  // without, with a normal
    for (const auto [u, v] : PixelsOf(camera)) {
      bool close = false;
      const auto slope_u = FittedSlope(depth_m, u, v, 1, 0, camera.fx, options, &close);
      const auto slope_v = FittedSlope(depth_m, u, v, 0, 1, camera.fy, options, &close);
      if (close) continue;
      const bool expected = depth_m(u, v) > 0 && slope_u && slope_v;
      ++seen[expected];
      ASSERT_EQ(!normal(u, v).isZero(0.f), expected) << u << ", " << v;
      if (!expected) continue;
      // Three points that span the fitted plane.
      const double r = 1.0 / depth_m(u, v), h = 1e-3;
      const Eigen::Vector3d x = camera.Ray(u, v) / r;
      const Eigen::Vector3d x_u = camera.Ray(u + h, v) / (r + h * *slope_u);
      const Eigen::Vector3d x_v = camera.Ray(u, v + h) / (r + h * *slope_v);
      const Eigen::Vector3d across = -(x_u - x).cross(x_v - x).normalized();
      // The difference of values near 2 is 1e-3 / 60, so the rounding error is 1e-10.
      ASSERT_THAT(normal(u, v).cast<double>(), VectorNear(across, NormalTolerance(camera) + 1e-9));
    }
    EXPECT_GT(seen[0], 500);
    EXPECT_GT(seen[1], 2000);
  }
}

TEST(NormalMap, NormalsHaveUnitLengthAndFaceCamera) {
  const PinholeCamera camera = SmallCamera();
  const Image<float> depth_m = RoughDepth(camera);
  const VectorImage normal = Normals(depth_m, camera);
  for (const auto [u, v] : PixelsOf(camera)) {
    const Eigen::Vector3d n = normal(u, v).cast<double>();
    if (n.isZero(0)) continue;
    EXPECT_GT(depth_m(u, v), 0);
    EXPECT_NEAR(n.norm(), 1, 6 * kFloatRounding);
    EXPECT_LT(n.dot(camera.Ray(u, v)), 0);
  }
}

// Pixels next to the step between two planes have no normal. Other pixels have the normal of their
// plane.
TEST(NormalMap, DoesNotSmoothAcrossDepthEdge) {
  const PinholeCamera camera = SmallCamera();
  const Plane near_plane = TiltedPlane(0.3, 1);
  Plane far_plane = TiltedPlane(0.4, 4);
  far_plane.distance_m = -3;
  Image<float> depth_m = PlaneDepth(near_plane, camera);
  const Image<float> far_depth_m = PlaneDepth(far_plane, camera);
  for (const auto [u, v] : Pixels(50, camera.width, 0, camera.height))
    depth_m(u, v) = far_depth_m(u, v);
  const VectorImage normal = Normals(depth_m, camera);
  for (const auto [u, v] : Pixels(1, camera.width - 1, 1, camera.height - 1)) {
    if (u == 49 || u == 50) {
      EXPECT_TRUE(normal(u, v).isZero(0.f)) << u << ", " << v;
    } else {
      const Eigen::Vector3d expected = (u < 50 ? near_plane : far_plane).normal;
      EXPECT_THAT(normal(u, v).cast<double>(), VectorNear(expected, NormalTolerance(camera)));
    }
  }
}

TEST(DropNormalsAtEdges, KeepsNormalsAwayFromDepthEdges) {
  PinholeCamera camera = SmallCamera();
  for (const int width : {5, camera.width}) {
    camera.width = width;
    FrameLevel surface;
    surface.camera = camera;
    surface.vertex = VertexMap(RoughDepth(camera), camera);
    surface.normal = VectorImage(camera.width, camera.height);
    for (const auto [u, v] : PixelsOf(camera)) surface.normal.Set(u, v, {0.6f, 0, -0.8f});
    const VectorImage own = NormalMap(surface.vertex, surface.sensor(), {});
    DropNormalsAtEdges({}, &surface);
    std::array<int, 2> seen = {0, 0};
    for (const auto [u, v] : PixelsOf(camera)) {
      const bool dropped = own(u, v).isZero(0.f);
      ++seen[dropped];
      const Eigen::Vector3f expected =
          dropped ? Eigen::Vector3f(0, 0, 0) : Eigen::Vector3f(0.6f, 0, -0.8f);
      ASSERT_EQ(surface.normal(u, v), expected) << u << ", " << v;
    }
    EXPECT_GT(seen[0], 50);
    EXPECT_GT(seen[1], 50);
  }
}

// The slope of 2 K + 1 values with equal noise has the variance sigma^2 / sum k^2 = sigma^2 / 28
// for K = 3. On a plane that faces the camera at depth z, n_x = f z r_u to first order.
TEST(NormalMap, HasNoiseOfLeastSquaresSlope) {
  PinholeCamera camera = {400, 400, 60, 60, 199.5, 199.5, {}};
  const PreprocessOptions options;
  const double sigma = 0.05 * DepthNoise().inverse_depth_sigma, z = 1.6;
  std::mt19937_64 rng(11);
  std::normal_distribution<double> noise(0, sigma);
  Image<float> depth_m(camera.width, camera.height);
  for (float& depth : depth_m) depth = static_cast<float>(1 / (1 / z + noise(rng)));
  const VectorImage normal = Normals(depth_m, camera, options);
  double square_sum = 0;
  int count = 0;
  for (int v = 3; v < 397; ++v) {
    // 7 px apart along u: slopes share no pixels.
    for (int u = 3; u < 397; u += 7, ++count) square_sum += std::pow(normal.x(u, v), 2);
  }
  const double expected = std::pow(camera.fx * z * sigma, 2) / 28;
  EXPECT_NEAR(square_sum / count, expected, 4 * std::sqrt(2.0 / count) * expected);
}

}  // namespace
}  // namespace surfit::testing
