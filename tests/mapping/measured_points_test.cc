#include "mapping/fusion/measured_points.h"

#include <gmock/gmock.h>

#include <cmath>

#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

FrameLevel Surface(const PinholeCamera& camera, const Eigen::Vector3f& normal, float depth_m) {
  FrameLevel surface{camera,
                     {},
                     VectorImage(camera.width, camera.height),
                     VectorImage(camera.width, camera.height),
                     {}};
  for (const auto [u, v] : PixelsOf(camera)) {
    surface.vertex.Set(u, v, (depth_m * camera.Ray(u, v)).cast<float>());
    surface.normal.Set(u, v, normal);
  }
  return surface;
}

MeasuredPoint PointAt(int u, int v, const RgbdFrame& frame, const FrameLevel& surface,
                      const FusionOptions& options = {}) {
  std::vector<MeasuredPoint> points;
  MeasurePoints(frame, surface, options, &points);
  EXPECT_EQ(points.size(), frame.depth_m.size());
  return points[v * frame.depth_m.width() + u];
}

RgbdFrame FrameOf(const PinholeCamera& camera, float depth_m) {
  RgbdFrame frame;
  frame.depth_m = Image<float>(camera.width, camera.height, depth_m);
  return frame;
}

PinholeCamera SevenByFive() { return {7, 5, 100, 100, 3, 2, {}}; }

// Relative error of a few float operations.
constexpr float kRounding = 5e-7f;

TEST(MeasurePoints, RadiusCoversFootprintOfPixel) {
  const PinholeCamera camera = SevenByFive();
  const RgbdFrame frame = FrameOf(camera, 2);
  for (const float tilt : {0.f, 0.3f, 0.9f, 1.04f}) {
    const Eigen::Vector3f normal(std::sin(tilt), 0, -std::cos(tilt));
    const float expected = std::sqrt(2.f) * 2 / 100 / std::cos(tilt);
    EXPECT_NEAR(PointAt(1, 1, frame, Surface(camera, normal, 2)).radius_m, expected,
                kRounding * expected);
  }
}

TEST(MeasurePoints, LimitsRadiusOfSlantedSurface) {
  const PinholeCamera camera = SevenByFive();
  const RgbdFrame frame = FrameOf(camera, 2);
  FusionOptions options;
  for (const float scale : {1.f, 2.f, 3.f}) {
    options.max_slant_scale = scale;
    const Eigen::Vector3f normal(0, std::sin(1.5f), -std::cos(1.5f));  // 1 / |n_z| = 14
    const float expected = scale * std::sqrt(2.f) * 2 / 100;
    EXPECT_NEAR(PointAt(3, 2, frame, Surface(camera, normal, 2), options).radius_m, expected,
                kRounding * expected);
  }
}

TEST(MeasurePoints, SkipsPixelsWithoutDepthOrNormal) {
  const PinholeCamera camera = SevenByFive();
  RgbdFrame frame = FrameOf(camera, 2);
  FrameLevel surface = Surface(camera, {0, 0, -1}, 2);
  frame.depth_m(1, 1) = 0;
  surface.normal = VectorImage(camera.width, camera.height);
  surface.normal.Set(3, 1, {0, 0, -1});
  EXPECT_EQ(PointAt(1, 1, frame, surface).radius_m, 0);
  EXPECT_EQ(PointAt(5, 1, frame, surface).radius_m, 0);  // neighbours have no normal either
  EXPECT_GT(PointAt(3, 1, frame, surface).radius_m, 0);
  EXPECT_EQ(PointAt(3, 1, frame, surface).position(), surface.vertex(3, 1));
  EXPECT_EQ(PointAt(3, 1, frame, surface).normal(), surface.normal(3, 1));
  EXPECT_FALSE(PointAt(3, 1, frame, surface).at_edge);
}

// Sigma is 8 mm at 2 m. A point within 4 mm of the plane of a neighbour is in the plane.
TEST(MeasurePoints, UsesNormalOfNeighbourAtDepthEdgeIfPointIsInItsPlane) {
  const PinholeCamera camera = SevenByFive();
  for (const float off_m : {-0.0042f, -0.0038f, 0.f, 0.0038f, 0.0042f}) {
    RgbdFrame frame = FrameOf(camera, 2);
    const FrameLevel plane = Surface(camera, {0, 0, -1}, 2);
    FrameLevel surface = plane;
    frame.depth_m(2, 1) += off_m;
    surface.normal.Set(2, 1, {0, 0, 0});
    const MeasuredPoint point = PointAt(2, 1, frame, surface);
    const bool in_plane = std::fabs(off_m) < 0.004f;
    EXPECT_EQ(point.radius_m > 0, in_plane) << off_m;
    EXPECT_EQ(point.normal(), in_plane ? plane.normal(2, 1) : Eigen::Vector3f(0, 0, 0)) << off_m;
    EXPECT_TRUE(point.at_edge) << off_m;
  }
}

// Step of 10 cm between columns 2 and 3, where both sides have no normals. The floor is on the
// left, and a steep wall is on the right.
TEST(MeasurePoints, UsesNormalOfNeighbourWithNearestPlane) {
  const PinholeCamera camera = SevenByFive();
  const Eigen::Vector3f near_normal(0, 0, -1), far_normal = Eigen::Vector3f(0, -1, -1).normalized();
  RgbdFrame frame = FrameOf(camera, 2);
  FrameLevel surface = Surface(camera, near_normal, 2);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 3; u < camera.width; ++u) {
      const Eigen::Vector3f ray = camera.Ray(u, v).cast<float>();
      frame.depth_m(u, v) = far_normal.z() * 2.1f / far_normal.dot(ray);
      surface.normal.Set(u, v, far_normal);
    }
    for (const int u : {2, 3}) surface.normal.Set(u, v, {0, 0, 0});
  }
  EXPECT_EQ(PointAt(2, 2, frame, surface).normal(), near_normal);
  EXPECT_EQ(PointAt(3, 2, frame, surface).normal(), far_normal);
}

// sigma_z = 0.002 z^2: a depth of 2 m frees space nearer than 2 - 0.05 - 4 * 0.008.
TEST(FreeDepths, EndBeforeNearestNeighbourDepth) {
  const PinholeCamera camera = SevenByFive();
  RgbdFrame frame = FrameOf(camera, 3);
  frame.depth_m(2, 2) = 2;
  const Image<float> free_depth_m = FreeDepths(frame.depth_m, {}, {});
  const float near = 2 - 0.05f - 0.032f, far = 3 - 0.05f - 0.072f;
  for (const auto [u, v] : PixelsOf(camera)) {
    const bool beside = std::abs(u - 2) <= 1 && std::abs(v - 2) <= 1;
    EXPECT_NEAR(free_depth_m(u, v), beside ? near : far, 3 * kRounding);
  }
}

TEST(FreeDepths, AreZeroNextToMissingDepth) {
  const PinholeCamera camera = SevenByFive();
  RgbdFrame frame = FrameOf(camera, 3);
  frame.depth_m(6, 0) = 0;
  const Image<float> free_depth_m = FreeDepths(frame.depth_m, {}, {});
  for (const auto [u, v] : PixelsOf(camera)) {
    EXPECT_EQ(free_depth_m(u, v) == 0, u >= 5 && v <= 1);
  }
}

TEST(FreeDepths, AreNeverNegative) {
  const PinholeCamera camera = SevenByFive();
  const Image<float> free_depth_m = FreeDepths(FrameOf(camera, 0.04f).depth_m, {}, {});
  EXPECT_EQ(free_depth_m(3, 2), 0);
}

TEST(PointWeights, DecreaseFromPrincipalPointToFarthestCorner) {
  const PinholeCamera camera{9, 7, 100, 100, 3, 4, {}};  // the farthest corner is (8, 0)
  const Image<float> weights = PointWeights(camera);
  EXPECT_EQ(weights(3, 4), 1);
  EXPECT_NEAR(weights(8, 0), std::exp(-1 / 0.72), kRounding);
  // The distance of (0, 0) is 5, and the distance of the farthest corner is sqrt(25 + 16).
  EXPECT_NEAR(weights(0, 0), std::exp(-25. / 41 / (2 * 0.6 * 0.6)), kRounding);
  for (const float weight : weights) {
    EXPECT_GE(weight, weights(8, 0));
    EXPECT_LE(weight, 1);
  }
}

}  // namespace
}  // namespace surfit::testing
