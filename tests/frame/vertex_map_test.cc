#include <gtest/gtest.h>

#include <random>

#include "frame/plane_images.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

using testing::kFloatRounding;

TEST(VertexMap, VerticesLieOnTheRaysOfTheirPixels) {
  const PinholeCamera camera = testing::SmallCamera();
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<float> depth(0.3f, 8.f);
  Image<float> depth_m(camera.width, camera.height);
  for (float& z : depth_m) z = depth(rng);
  const VectorImage vertex = VertexMap(depth_m, camera);
  ASSERT_EQ(vertex.width(), camera.width);
  ASSERT_EQ(vertex.height(), camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double z = depth_m(u, v);
      EXPECT_EQ(vertex.z(u, v), depth_m(u, v));
      // (u - cx) / fx < 1: cx, the difference, 1 / fx and two products are rounded.
      const Eigen::Vector3d point = vertex(u, v).cast<double>();
      EXPECT_LT((point - z * camera.Ray(u, v)).norm(), 6 * kFloatRounding * z);
      // The same in pixels, seen from z.
      const Eigen::Vector2d pixel = camera.Project(point);
      EXPECT_LT((pixel - Eigen::Vector2d(u, v)).norm(), 6 * kFloatRounding * camera.fx);
    }
  }
}

TEST(VertexMap, IsZeroWhereDepthIsMissing) {
  Image<float> depth_m(9, 7, 0.f);
  depth_m(4, 3) = 2.f;
  const VectorImage vertex = VertexMap(depth_m, testing::SmallCamera());
  for (int v = 0; v < 7; ++v) {
    for (int u = 0; u < 9; ++u) EXPECT_EQ(vertex(u, v).isZero(0.f), u != 4 || v != 3);
  }
}

}  // namespace
}  // namespace surfit
