#include "registration/global/projections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "registration/simulated_views.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

// A slanted surface with holes. The width is no multiple of Projections::kCapacity.
FrameLevel SlantWithHoles() {
  FrameLevel level;
  level.camera = {150, 20, 120, 120, 74.5, 9.5, {}};
  level.vertex = VectorImage(150, 20);
  level.normal = VectorImage(150, 20);
  for (const auto [u, v] : PixelsOf(150, 20)) {
    const double depth_m = (u + v) % 7 == 0 ? 0 : 1 + 0.01 * u;
    level.vertex.Set(u, v, (depth_m * level.camera.Ray(u, v)).cast<float>());
    level.normal.Set(u, v, {0, 0, -1});
  }
  return level;
}

struct Landing {
  int source_pixel, target_pixel;
};

std::vector<Landing> Landings(const FrameLevel& level, const Rigid3d& motion, int stride) {
  std::vector<Landing> landings;
  ForEachProjections(level, level, motion, stride, [&](const Projections& at) {
    for (int k = 0; k < at.count; ++k) {
      landings.push_back({at.source_pixel[k], at.target_pixel[k]});
      const Eigen::Vector2d pixel = level.camera.Project(at.Point(k).cast<double>());
      EXPECT_NEAR(at.u[k], pixel.x(), 1e-3);
      EXPECT_NEAR(at.v[k], pixel.y(), 1e-3);
    }
  });
  return landings;
}

TEST(ForEachProjections, VisitsEachPixelWithDepthOnce) {
  const FrameLevel level = SlantWithHoles();
  for (const int stride : {1, 3}) {
    std::vector<int> expected;
    for (int v = stride / 2; v < 20; v += stride) {
      for (int u = stride / 2; u < 150; u += stride) {
        if (level.vertex.z(u, v) > 0) expected.push_back(v * 150 + u);
      }
    }
    const std::vector<Landing> landings = Landings(level, Rigid3d(), stride);
    ASSERT_EQ(landings.size(), expected.size()) << stride;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(landings[i].source_pixel, expected[i]) << stride;
      EXPECT_EQ(landings[i].target_pixel, expected[i]) << stride;
    }
  }
}

TEST(ForEachProjections, SkipsPointsOutsideOfTheTargetImage) {
  const FrameLevel level = SlantWithHoles();
  const Rigid3d motion(QuaternionExp<double>(Eigen::Vector3d(0, 0.1, 0.05)), {0.2, -0.05, 0.1});
  std::size_t inside = 0;
  for (const auto [u, v] : PixelsOf(150, 20)) {
    if (!(level.vertex.z(u, v) > 0)) continue;
    const Eigen::Vector2d pixel =
        level.camera.Project(motion * Eigen::Vector3d(level.vertex(u, v).cast<double>()));
    inside += pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < 149.5 && pixel.y() < 19.5;
  }
  const std::vector<Landing> landings = Landings(level, motion, 1);
  EXPECT_EQ(landings.size(), inside);
  EXPECT_GT(inside, 500u);
  EXPECT_LT(inside, 2500u);
}

TEST(ForEachProjections, SkipsPointsBehindAndNearTheCamera) {
  const FrameLevel level = SlantWithHoles();
  EXPECT_TRUE(Landings(level, {Eigen::Quaterniond::Identity(), {0, 0, -5}}, 1).empty());
  EXPECT_TRUE(Landings(level, {Eigen::Quaterniond::Identity(), {0, 0, -2.46}}, 1).empty());
}

}  // namespace
}  // namespace surfit::testing
