#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/evaluate/rolling_shutter_view.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

PinholeCamera WallCamera() { return {160, 120, 150, 150, 79.5, 59.5, {}}; }

// A wall at 2 m, rendered with the margin. Red increases along u, and green along v.
BlendedView Wall() {
  const PinholeCamera camera = WithRollMargin(WallCamera());
  BlendedView wall = {Image<Rgb8>(camera.width, camera.height),
                      Image<float>(camera.width, camera.height, 2.f)};
  for (const auto [u, v] : PixelsOf(wall.color)) {
    wall.color(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 7};
  }
  return wall;
}

// The point of each pixel, moved by the documented motion, must have its colour at its new pixel.
// Tolerance: half a colour step, plus the error after three iterations.
TEST(Rolled, ShowsPointsAtTheTimeOfTheirRow) {
  const PinholeCamera camera = WallCamera(), wide = WithRollMargin(camera);
  const CameraMotion motion = {{0.3, -0.6, 0.4}, {0.2, 0.1, -0.3}};
  const BlendedView rolled = Rolled(Wall(), camera, motion, {0.01, 1. / 30});
  double most_px = 0;
  for (const auto [u, v] : PixelsOf(rolled.color)) {
    ASSERT_GT(rolled.depth_m(u, v), 0) << u << " " << v;
    const Eigen::Vector3d x = 2 * wide.Ray(rolled.color(u, v).r, rolled.color(u, v).g);
    const double t = 0.01 + ((v + 0.5) / 120 - 0.5) / 30;
    const Eigen::Vector3d moved =
        x - t * (motion.angular_velocity_rad_per_s.cross(x) + motion.velocity_m_per_s);
    const Eigen::Vector2d seen = camera.Project(moved);
    EXPECT_NEAR(seen.x(), u, 0.6);
    EXPECT_NEAR(seen.y(), v, 0.6);
    most_px = std::max(most_px, (camera.Project(x) - seen).norm());
  }
  EXPECT_GT(most_px, 2);  // otherwise the motion is too small to test
}

TEST(Rolled, WithoutMotionIsTheImageWithoutMargin) {
  const BlendedView wall = Wall();
  for (const auto& [motion, times] : {std::pair(CameraMotion(), RowTimes{0.01, 0.03}),
                                      std::pair(CameraMotion{{1, 0, 0}, {0, 0, 0}}, RowTimes())}) {
    const BlendedView rolled = Rolled(wall, WallCamera(), motion, times);
    for (const auto [u, v] : PixelsOf(rolled.color)) {
      EXPECT_EQ(rolled.color(u, v), wall.color(u + kRollMargin_px, v + kRollMargin_px));
    }
  }
}

TEST(Rolled, DoesNotExtendTheCoverage) {
  BlendedView wall = Wall();
  for (const auto [u, v] : PixelsOf(wall.color)) {
    if (u < 110) wall.depth_m(u, v) = 0, wall.color(u, v) = {};
  }
  const BlendedView rolled = Rolled(wall, WallCamera(), {{0, 0.2, 0}, {0, 0, 0}}, {0.02, 0});
  int covered = 0;
  for (const auto [u, v] : PixelsOf(rolled.color)) {
    const bool is_covered = rolled.depth_m(u, v) > 0;
    EXPECT_EQ(rolled.color(u, v) != Rgb8(), is_covered);
    EXPECT_GE(rolled.color(u, v).r, is_covered ? 110 : 0);
    covered += is_covered;
  }
  EXPECT_GT(covered, 80 * 120 / 2);
}

}  // namespace
}  // namespace surfit::testing
