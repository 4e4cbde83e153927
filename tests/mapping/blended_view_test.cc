#include "mapping/rendering/blended_view.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "mapping/random_surfel.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kRed = {200, 10, 10}, kBlue = {10, 10, 200};

// Adds a wall across the view at this depth. The surfels have a spacing of 5 mm (1.5 px at 1 m),
// and their discs just cover the wall.
void AddWall(float depth_m, const std::function<std::optional<Rgb8>(float x, float y)>& color_at,
             SurfelMap* map) {
  for (int i = -300; i <= 300; ++i) {
    for (int j = -250; j <= 250; ++j) {
      const float x = 0.005f * i, y = 0.005f * j;
      const std::optional<Rgb8> color = color_at(x, y);
      if (!color) continue;
      Surfel s = Disc({x, y, depth_m}, {0, 0, -1}, 0.0036f, 20);
      s.color = *color;
      map->Append(s);
    }
  }
}

// Camera with pixels of 3.3 mm at 1 m.
PinholeCamera FineCamera() { return {160, 120, 300, 300, 79.3, 59.6, {}}; }

TEST(DrawBlended, ShowsFirstSurfaceOnly) {
  SurfelMap map;
  AddWall(
      1, [](float, float) { return kRed; }, &map);
  AddWall(
      1.2f, [](float, float) { return kBlue; }, &map);
  const BlendedView view = DrawBlended(map, {FineCamera(), {}}, {});
  for (const auto [u, v] : PixelsOf(view.depth_m)) {
    ASSERT_EQ(view.color(u, v), kRed) << u << " " << v;
    ASSERT_NEAR(view.depth_m(u, v), 1, 1e-5);
  }
}

TEST(DrawBlended, IsEmptyForEmptyMap) {
  const BlendedView view = DrawBlended({}, {SmallCamera(), {}}, {});
  EXPECT_EQ(view.color, Image<Rgb8>(64, 48));
  EXPECT_EQ(view.depth_m, Image<float>(64, 48, 0.f));
}

// The radius of splats is 7.2 mm, and 14.4 mm for splats that fill holes.
TEST(DrawBlended, FillsSmallHolesOnly) {
  SurfelMap map;
  const auto is_in = [](float x, float y, float cx, float half) {
    return std::abs(x - cx) < half && std::abs(y) < half;
  };
  AddWall(
      1,
      [&](float x, float y) -> std::optional<Rgb8> {
        const bool is_hole = is_in(x, y, -0.1f, 0.011f) || is_in(x, y, 0.1f, 0.031f);
        return is_hole ? std::nullopt : std::optional<Rgb8>(kRed);
      },
      &map);
  const PinholeCamera camera = FineCamera();
  const BlendedView view = DrawBlended(map, {camera, {}}, {});
  const auto depth_at = [&](float x) {
    return view.depth_m(static_cast<int>(std::lround(camera.fx * x + camera.cx)), 60);
  };
  EXPECT_NEAR(depth_at(-0.1f), 1, 1e-5);
  EXPECT_EQ(depth_at(0.1f), 0);
  EXPECT_NEAR(depth_at(0.05f), 1, 1e-5);
}

// Splats that fill holes reach 14.4 mm (4.3 px), others 7.2 mm (2.2 px).
TEST(DrawBlended, FillersDoNotExtendASurface) {
  SurfelMap map;
  AddWall(
      1, [](float x, float) { return x < 0 ? std::optional<Rgb8>(kRed) : std::nullopt; }, &map);
  const PinholeCamera camera = FineCamera();
  const BlendedView view = DrawBlended(map, {camera, {}}, {});
  const double edge_px = camera.fx * -0.005 + camera.cx;
  for (int v = 0; v < 120; ++v) {
    EXPECT_GT(view.depth_m(static_cast<int>(edge_px), v), 0);
    for (int u = static_cast<int>(edge_px + 3.2); u < 160; ++u) {
      ASSERT_EQ(view.depth_m(u, v), 0) << u << " " << v;
    }
  }
}

TEST(DrawBlended, BlendsWithinTwoRadiiOfBorder) {
  SurfelMap map;
  AddWall(
      1, [](float x, float) { return x < 0 ? kRed : kBlue; }, &map);
  const BlendedView view = DrawBlended(map, {FineCamera(), {}}, {});
  int between = 0;
  for (int u = 1; u < 160; ++u) {
    EXPECT_LE(view.color(u, 60).r, view.color(u - 1, 60).r + 1);
    between += view.color(u, 60).r < 195 && view.color(u, 60).r > 15;
  }
  EXPECT_EQ(view.color(70, 60), kRed);
  EXPECT_EQ(view.color(90, 60), kBlue);
  EXPECT_GE(between, 1);
  EXPECT_LE(between, 5);  // 14.4 mm
}

// Blending rule of the header, in double precision at one pixel. std::nullopt if no disc covers the
// pixel. With `gaps_only` also std::nullopt if all discs are on one side of the pixel.
std::optional<Eigen::Vector3d> BlendedAt(const SurfelMap& map, const PinholeCamera& camera, int u,
                                         int v, double share, bool stable, bool gaps_only) {
  struct Met {
    double depth_m, offset2;
    Eigen::Vector3d color;
    Eigen::Vector2d side;
  };
  std::vector<Met> met;
  for (const std::int32_t id : map.Ids()) {
    const Surfel s = map[id];
    const Eigen::Vector3d p = s.position_in_world.cast<double>(),
                          n = s.normal_in_world.cast<double>(), ray = camera.Ray(u, v);
    if ((s.confidence >= 10) != stable || p.z() < 0.06 || n.dot(p) > -1e-3) continue;
    // Pixels outside the radius of the disc in the image plane are not drawn.
    const Eigen::Vector2d off = camera.Project(p) - Eigen::Vector2d(u, v);
    if (off.lpNorm<Eigen::Infinity>() > camera.fx * share * s.radius_m / p.z()) continue;
    const double depth_m = n.dot(p) / n.dot(ray);
    const double offset = (depth_m * ray - p).norm() / (share * s.radius_m);
    if (depth_m > 0 && offset <= 1) {
      met.push_back(
          {depth_m, offset * offset, {1. * s.color.r, 1. * s.color.g, 1. * s.color.b}, off});
    }
  }
  if (met.empty()) return std::nullopt;
  double first = 1e9, weights = 0, length = 0;
  Eigen::Vector2d side = Eigen::Vector2d::Zero();
  for (const Met& m : met) first = std::min(first, m.depth_m);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Met& m : met) {
    if (m.depth_m > first + 0.03 + 4 * DepthNoise().SigmaZ(first)) continue;
    const double weight = std::pow(1 - m.offset2, 8) + 1e-6;
    weights += weight;
    sum += weight * m.color;
    side += (1 - m.offset2) * m.side;
    length += (1 - m.offset2) * m.side.norm();
  }
  if (gaps_only && side.norm() > 0.75 * length) return std::nullopt;
  return sum / weights;
}

TEST(DrawBlended, AgreesWithBruteForce) {
  std::mt19937_64 rng(3);
  SurfelMap map;
  for (int i = 0; i < 400; ++i) {
    const float z = Uniform(0.8f, 1.4f, &rng);
    Surfel s = Disc({z * Uniform(-0.5f, 0.5f, &rng), z * Uniform(-0.4f, 0.4f, &rng), z},
                    RandomNormal(1, &rng), Uniform(0.01f, 0.03f, &rng), Uniform(0, 20, &rng));
    s.color = RandomColor(&rng);
    map.Append(s);
  }
  const PinholeCamera camera = SmallCamera();
  const BlendedView view = DrawBlended(map, {camera, {}}, {});
  int wrong = 0, drawn = 0, empty = 0;
  for (const auto [u, v] : PixelsOf(view.depth_m)) {
    std::optional<Eigen::Vector3d> expected;
    for (const double share : {2., 4.}) {
      for (const bool stable : {true, false}) {
        if (!expected) expected = BlendedAt(map, camera, u, v, share, stable, share == 4);
      }
    }
    EXPECT_EQ(view.depth_m(u, v) > 0, expected.has_value());
    ++(expected ? drawn : empty);
    if (!expected) continue;
    const Rgb8 color = view.color(u, v);
    const Eigen::Vector3d error = *expected - Eigen::Vector3d(color.r, color.g, color.b);
    wrong +=
        error.lpNorm<Eigen::Infinity>() > 0.6;  // rounding to grey values, and single precision
  }
  EXPECT_GT(drawn, 1000);
  EXPECT_GT(empty, 10);
  EXPECT_LE(wrong, 3);  // of 3072, due to rounding at disc borders
}

TEST(DrawBlendedThreads, AreBitwiseIdentical) {
  std::mt19937_64 rng(5);
  const Rigid3d pose = RandomPose(1, 1, &rng);
  const SurfelMap map = RandomDiscs(4000, 0.05f, pose, &rng);
  const auto views = AtThreads({1, 2, 5}, [&] {
    return DrawBlended(map, {SmallCamera(), {}}, pose);
  });
  for (const BlendedView& view : views) {
    EXPECT_EQ(view.color, views[0].color);
    EXPECT_EQ(view.depth_m, views[0].depth_m);
  }
}

}  // namespace
}  // namespace surfit::testing
