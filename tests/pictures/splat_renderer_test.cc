#include "output/pictures/splat_renderer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr std::int32_t kNothing = NearestIndexImage::kNothing;

// 101 x 101 pixels. The central pixel is on the optical axis. A pixel is 1 cm wide at z = 1 m.
PictureView TestView() {
  PictureView view;
  view.camera.width = view.camera.height = 101;
  view.camera.fx = view.camera.fy = 100;
  view.camera.cx = view.camera.cy = 50;
  return view;
}

Surfel MakeSurfel(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float radius_m) {
  Surfel surfel;
  surfel.position_in_world = position;
  surfel.normal_in_world = normal.normalized();
  surfel.radius_m = radius_m;
  return surfel;
}

Image<std::int32_t> Render(const SurfelMap& map, const PictureView& view = TestView()) {
  std::vector<std::uint8_t> shown(map.id_end(), 0);
  for (const std::int32_t id : map.Ids()) shown[id] = 1;
  return RenderSurfels(map, shown, view);
}

const Eigen::Vector3f kTowardsCamera(0, 0, -1);

TEST(RenderSurfels, DiscThatFacesTheCameraFillsACircle) {
  SurfelMap map;
  // The radius is 20.05 pixels, and 20.05^2 = 402.0025. Squared pixel distances are integers, and
  // 402 is not a sum of two squares. So no pixel is at the border of the disc.
  map.Append(MakeSurfel({0, 0, 2}, kTowardsCamera, 0.401f));
  const Image<std::int32_t> seen = Render(map);
  for (const auto [u, v] : PixelsOf(101, 101)) {
    const int distance2 = (u - 50) * (u - 50) + (v - 50) * (v - 50);
    EXPECT_EQ(seen(u, v), distance2 <= 402 ? 0 : kNothing) << u << ", " << v;
  }
}

// Compares with the intersection of each pixel ray and the disc, in double precision.
TEST(RenderSurfels, TiltedDiscsCoverPixelsWithIntersectingRays) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  int covered = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3f position(uniform(rng), uniform(rng), 2.5f + uniform(rng));
    Eigen::Vector3f normal = Eigen::Vector3f(uniform(rng), uniform(rng), uniform(rng)).normalized();
    if (normal.dot(position) > 0) normal = -normal;
    const float radius = 0.3f + 0.2f * uniform(rng);
    SurfelMap map;
    map.Append(MakeSurfel(position, normal, radius));
    const Image<std::int32_t> seen = Render(map);
    const Eigen::Vector3d c = position.cast<double>(), n = normal.cast<double>();
    const Eigen::Vector2d center = TestView().camera.Project(c);
    for (const auto [u, v] : PixelsOf(101, 101)) {
      if ((Eigen::Vector2d(u, v) - center).cwiseAbs().maxCoeff() < 0.6) continue;
      const Eigen::Vector3d ray = TestView().camera.Ray(u, v);
      const double distance = (n.dot(c) / n.dot(ray) * ray - c).norm();
      const bool in_front = n.dot(ray) < 0;
      // Rounding of metres in single precision, times 10 for the slant of the disc.
      if (std::abs(distance - radius) < 1e-4) continue;
      covered += in_front && distance < radius;
      EXPECT_EQ(seen(u, v), in_front && distance < radius ? 0 : kNothing) << u << ", " << v;
    }
  }
  EXPECT_GT(covered, 1000);
}

TEST(RenderSurfels, CloserDiscOccludesTheOtherInAnyOrder) {
  const Surfel near = MakeSurfel({0, 0, 1}, kTowardsCamera, 0.1f);
  const Surfel far = MakeSurfel({0, 0, 2}, kTowardsCamera, 0.6f);
  SurfelMap near_first, far_first;
  const std::int32_t near_0 = near_first.Append(near), far_1 = near_first.Append(far);
  const std::int32_t far_0 = far_first.Append(far), near_1 = far_first.Append(near);
  EXPECT_EQ(Render(near_first)(50, 50), near_0);
  EXPECT_EQ(Render(near_first)(70, 50), far_1);
  EXPECT_EQ(Render(far_first)(50, 50), near_1);
  EXPECT_EQ(Render(far_first)(70, 50), far_0);
}

TEST(RenderSurfels, IntersectingDiscsAreSplitAtTheIntersection) {
  SurfelMap map;
  map.Append(MakeSurfel({0, 0, 2}, {0.5f, 0, -1}, 0.5f));   // closer on the left
  map.Append(MakeSurfel({0, 0, 2}, {-0.5f, 0, -1}, 0.5f));  // closer on the right
  const Image<std::int32_t> seen = Render(map);
  EXPECT_EQ(seen(40, 50), 0);
  EXPECT_EQ(seen(60, 50), 1);
}

TEST(RenderSurfels, EqualDepthReturnsTheLowestIndex) {
  SurfelMap map;
  for (int i = 0; i < 3; ++i) map.Append(MakeSurfel({0, 0, 2}, kTowardsCamera, 0.3f));
  EXPECT_EQ(Render(map)(45, 50), 0);
}

TEST(RenderSurfels, BackFacingDiscIsNotDrawn) {
  SurfelMap map;
  map.Append(MakeSurfel({0, 0, 2}, -kTowardsCamera, 0.4f));
  EXPECT_THAT(Render(map), Each(kNothing));
}

TEST(RenderSurfels, DiscBehindTheCameraOrHiddenIsNotDrawn) {
  SurfelMap map;
  map.Append(MakeSurfel({0, 0, -2}, -kTowardsCamera, 0.4f));
  map.Append(MakeSurfel({0, 0, 0.1f}, kTowardsCamera, 0.4f));
  EXPECT_THAT(Render(map), Each(kNothing));
  const std::int32_t id = map.Append(MakeSurfel({0, 0, 2}, kTowardsCamera, 0.4f));
  EXPECT_EQ(Render(map)(50, 50), id);
  const std::vector<std::uint8_t> none(map.id_end(), 0);
  EXPECT_THAT(RenderSurfels(map, none, TestView()), Each(kNothing));
}

TEST(RenderSurfels, SmallDiscCoversItsPixel) {
  SurfelMap map;
  map.Append(MakeSurfel({0.006f, 0.004f, 1}, kTowardsCamera, 1e-5f));  // at (50.6, 50.4)
  const Image<std::int32_t> seen = Render(map);
  EXPECT_EQ(seen(51, 50), 0);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 0), 1);
}

TEST(RenderSurfels, UsesThePoseOfTheView) {
  PictureView view = TestView();
  view.camera_from_world.translation = {0.1, 0, 1};
  SurfelMap map;
  map.Append(MakeSurfel({0, 0, 1}, kTowardsCamera, 1e-5f));  // at (0.1, 0, 2): (55, 50)
  EXPECT_EQ(Render(map, view)(55, 50), 0);
}

TEST(RenderSurfels, IsTheSameAtAnyNumberOfThreads) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  SurfelMap map;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3f position(uniform(rng), uniform(rng), 2 + 0.1f * uniform(rng));
    map.Append(MakeSurfel(position, {uniform(rng), uniform(rng), -1}, 0.02f));
  }
  const auto images = AtThreads({1, 2, 4}, [&] { return Render(map); });
  EXPECT_EQ(images[0], images[1]);
  EXPECT_EQ(images[0], images[2]);
}

TEST(RenderPoints, PointCoversASquareAndTheCloserPointWins) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 1}, {0.02f, 0, 2}};  // at 50, 51
  const Image<std::int32_t> seen = RenderPoints(points, 3, TestView());
  for (const auto [u, v] : PixelsOf(101, 101)) {
    const bool row = std::abs(v - 50) <= 1;
    const int expected = row && std::abs(u - 50) <= 1 ? 0 : row && u == 52 ? 1 : kNothing;
    EXPECT_EQ(seen(u, v), expected) << u << ", " << v;
  }
}

}  // namespace
}  // namespace surfit::testing
