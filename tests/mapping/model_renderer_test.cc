#include "surfit/mapping/model_renderer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "mapping/random_surfel.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

TEST(ModelRenderer, WritesDiscOfSurfelIndex) {
  std::mt19937_64 rng(3);
  const Rigid3d world_from_view = RandomPose(2, 2, &rng);
  const SurfelMap map = RandomDiscs(500, 0.15f, world_from_view, &rng);
  const PinholeCamera camera = SmallCamera();
  const ModelView view = ModelRenderer({}).Render(map, {camera, {}}, world_from_view);
  const Image<Rgb8> colors = ColorsOf(view, map);
  EXPECT_EQ(view.surface.camera.width, camera.width);
  EXPECT_EQ(view.world_from_view.Matrix(), world_from_view.Matrix());
  for (const auto [u, v] : PixelsOf(camera)) {
    const std::int32_t i = view.surfel_index(u, v);
    const Eigen::Vector3d vertex = view.surface.vertex(u, v).cast<double>();
    const Eigen::Vector3f normal = view.surface.normal(u, v);
    if (i == ModelView::kNoSurfel) {
      EXPECT_TRUE(vertex.isZero(0) && normal.isZero(0));
      EXPECT_EQ(colors(u, v), Rgb8());
      continue;
    }
    EXPECT_EQ(colors(u, v), map.Color(i));
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
    EXPECT_LT(normal.dot(view.surface.vertex(u, v)), 0) << "seen from behind";
    // The vertex is on the ray of its pixel, up to rounding. The distance to the plane has a few
    // roundings of positions up to 5 m in single precision.
    EXPECT_THAT(camera.Project(vertex), VectorNear(Eigen::Vector2d(u, v), 1e-4));
    const Eigen::Vector3d in_world = world_from_view * vertex;
    const Eigen::Vector3d gap = in_world - map[i].position_in_world.cast<double>();
    EXPECT_NEAR(map[i].normal_in_world.cast<double>().dot(gap), 0, 1e-5);
    EXPECT_LE(gap.norm(), RenderOptions().radius_ratio * map[i].radius_m + 1e-5);
  }
}

TEST(ModelRenderer, IsEmptyForEmptyMap) {
  const ModelView view = ModelRenderer({}).Render({}, {SmallCamera(), {}}, {});
  EXPECT_EQ(view.surfel_index, Image<std::int32_t>(64, 48, ModelView::kNoSurfel));
  EXPECT_THAT(view.surface.vertex.z, Each(0.f));
  EXPECT_THAT(view.surface.normal.z, Each(0.f));
  EXPECT_EQ(ColorsOf(view, {}), Image<Rgb8>(64, 48));
}

TEST(ModelRenderer, DrawsActiveSurfelsOnly) {
  SurfelMap map;
  Surfel surfel;
  surfel.position_in_world = {0, 0, 1};
  surfel.normal_in_world = {0, 0, -1};
  surfel.radius_m = 0.1f;
  surfel.confidence = 100;
  surfel.last_seen = 7;
  map.Append(surfel);
  const auto seen = [&](int active_since) {
    return ModelRenderer({}).Render(map, {SmallCamera(), {}}, {}, active_since).surfel_index;
  };
  EXPECT_THAT(seen(7), ::testing::Contains(0));
  EXPECT_THAT(seen(8), Each(ModelView::kNoSurfel));
}

TEST(ModelRenderer, DoesNotKeepLastView) {
  SurfelMap map;
  map.Append(Disc({0, 0, 1}, {0, 0, -1}, 0.1f, 20));
  ModelRenderer renderer({});
  EXPECT_THAT(renderer.Render(map, {SmallCamera(), {}}, {}).surfel_index, ::testing::Contains(0));
  EXPECT_THAT(renderer.Render({}, {SmallCamera(), {}}, {}).surfel_index,
              Each(ModelView::kNoSurfel));
  EXPECT_EQ(renderer.Render({}, {{5, 3, 60, 60, 2, 1, {}}, {}}, {}).surfel_index.size(), 15u);
}

// Adds a wall with one surfel per pixel of a camera at the origin, at this depth.
template <typename Change>
void AppendWall(float depth_m, float confidence, const PinholeCamera& camera, SurfelMap* map,
                const Change& change) {
  for (const auto [u, v] : PixelsOf(camera)) {
    Surfel surfel = Disc((depth_m * camera.Ray(u, v)).template cast<float>(), {0, 0, -1},
                         std::sqrt(2.f) * depth_m / 60, confidence);
    change(&surfel);
    map->Append(surfel);
  }
}

void AppendWall(float depth_m, float confidence, const PinholeCamera& camera, SurfelMap* map) {
  AppendWall(depth_m, confidence, camera, map, [](Surfel*) {});
}

TEST(ModelRenderer, NearerWallOccludesFartherWall) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(2, 20, camera, &map);
  AppendWall(1.5f, 20, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, {camera, {}}, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 1.5, 1e-6);
}

// Mean depth error of the rendering of two walls at the same depth, with M surfels and noise sigma.
// Most rays intersect several discs.
double MeanErrorOfNoisyWall(float sigma, const RenderOptions& options, const DepthNoise& noise) {
  const PinholeCamera camera = SmallCamera();
  std::mt19937_64 rng(5);
  std::normal_distribution<float> error(0, sigma);
  SurfelMap map;
  const auto add_noise = [&](Surfel* s) { s->position_in_world.z() += error(rng); };
  AppendWall(2, 20, camera, &map, add_noise);
  AppendWall(2, 20, camera, &map, add_noise);
  const ModelView view = ModelRenderer(options).Render(map, {camera, noise}, {});
  double sum = 0;
  for (const float z : view.surface.vertex.z) sum += z - 2;
  return sum / static_cast<double>(view.surface.vertex.z.size());
}

// The bound is five standard errors of M / 4 values. If the first disc were always drawn, the mean
// would be nearer by sigma / sqrt(pi).
TEST(ModelRenderer, NoiseDoesNotBiasDepth) {
  constexpr float kSigma = 0.005f;
  EXPECT_NEAR(MeanErrorOfNoisyWall(kSigma, {}, {}), 0, 5 * kSigma / std::sqrt(2 * 64 * 48 / 4));
  RenderOptions first_disc;
  first_disc.surface_thickness_m = 0;
  EXPECT_LT(MeanErrorOfNoisyWall(kSigma, first_disc, {0}), -kSigma / std::sqrt(M_PI));
}

TEST(ModelRenderer, PrefersStableWallToUnstableWall) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(1.5f, 0.999f * RenderOptions().stable_confidence, camera, &map);
  const ModelView unstable = ModelRenderer({}).Render(map, {camera, {}}, {});
  for (const float z : unstable.surface.vertex.z) EXPECT_NEAR(z, 1.5, 1e-6);
  AppendWall(2, RenderOptions().stable_confidence, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, {camera, {}}, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 2, 1e-6);
}

TEST(ModelRenderer, DoesNotDrawSurfelsOfDepthEdges) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(1.5f, RenderOptions().stable_confidence, camera, &map,
             [](Surfel* s) { s->at_edge = true; });
  AppendWall(2, RenderOptions().stable_confidence, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, {camera, {}}, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 2, 1e-6);
}

// Discs with 0.6 times the radius of sqrt(2) pixels cover the gaps of the pixel grid, also in views
// between its points and in nearer views.
TEST(ModelRenderer, WallOfPixelsHasNoHoles) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(2, 20, camera, &map);
  for (const double step : {0., 0.01, 0.017, 0.02}) {
    Rigid3d pose(QuaternionExp<double>({0, 0, 10 * step}),
                 Eigen::Vector3d(step, step / 2, 5 * step));
    const ModelView view = ModelRenderer({}).Render(map, {camera, {}}, pose);
    for (const auto [u, v] : Pixels(16, 48, 12, 36)) {
      EXPECT_NE(view.surfel_index(u, v), ModelView::kNoSurfel) << step << " " << u << " " << v;
    }
  }
}

TEST(ModelRenderer, DoesNotDrawBackFacesAndDiscsBehindCamera) {
  SurfelMap map;
  map.Append(Disc({0, 0, 1}, {0, 0, 1}, 0.2f, 20));
  map.Append(Disc({0, 0, -1}, {0, 0, -1}, 0.2f, 20));
  map.Append(Disc({0, 0, -1}, {0, 0, 1}, 0.2f, 20));
  map.Append(Disc({0, 0, 0}, {0, 0, -1}, 0.2f, 20));
  const ModelView view = ModelRenderer({}).Render(map, {SmallCamera(), {}}, {});
  EXPECT_THAT(view.surfel_index, Each(ModelView::kNoSurfel));
}

TEST(ModelRendererThreads, ViewsAreBitwiseIdenticalAtAnyNumberOfThreads) {
  std::mt19937_64 rng(4);
  const Rigid3d pose = RandomPose(2, 2, &rng);
  const SurfelMap map = RandomDiscs(60000, 0.1f, pose, &rng);
  const auto views = AtThreads({1, 2, 4}, [&] {
    return ModelRenderer({}).Render(map, {SmallCamera(), {}}, pose);
  });
  for (const ModelView& view : views) {
    EXPECT_TRUE(view.surfel_index == views[0].surfel_index);
    EXPECT_TRUE(view.surface.vertex.x == views[0].surface.vertex.x &&
                view.surface.vertex.y == views[0].surface.vertex.y &&
                view.surface.vertex.z == views[0].surface.vertex.z);
    EXPECT_TRUE(view.surface.normal.x == views[0].surface.normal.x &&
                view.surface.normal.y == views[0].surface.normal.y &&
                view.surface.normal.z == views[0].surface.normal.z);
  }
}

TEST(RenderOptions, RejectInvalidValues) {
  const auto expect_refused = [](auto change, const std::string& field, const std::string& value) {
    RenderOptions options;
    change(options);
    ExpectInputError([&] { Validate(options); }, Names(field, value));
    ExpectInputError([&] { ModelRenderer renderer(options); }, Names(field, value));
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Validate(RenderOptions());
  expect_refused([](auto& o) { o.stable_confidence = -1; }, "stable_confidence", "-1");
  expect_refused([](auto& o) { o.radius_ratio = 0; }, "radius_ratio", "0");
  expect_refused([](auto& o) { o.radius_ratio = kNan; }, "radius_ratio", "nan");
  expect_refused([](auto& o) { o.max_half_window_px = -1; }, "max_half_window_px", "-1");
  expect_refused([](auto& o) { o.max_half_window_px = 65; }, "max_half_window_px", "65");
  expect_refused([](auto& o) { o.surface_thickness_m = -1; }, "surface_thickness_m", "-1");
}

}  // namespace
}  // namespace surfit::testing
