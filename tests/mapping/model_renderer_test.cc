#include "surfit/mapping/model_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "mapping/random_surfel.h"
#include "surfit/core/parallel.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using ::testing::Each;
using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::RandomColor;
using testing::RandomNormal;
using testing::RandomPose;
using testing::Uniform;
using testing::VectorNear;

PinholeCamera SmallCamera() { return {64, 48, 60, 61, 30.5, 24.25, {}}; }

// The surfel of a disc given in the camera's frame.
Surfel Disc(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float radius_m,
            float confidence, const Rigid3d& world_from_camera = {}) {
  Surfel s;
  s.position_in_world = (world_from_camera * position.cast<double>()).cast<float>();
  s.normal_in_world = (world_from_camera.rotation * normal.cast<double>()).cast<float>();
  s.radius_m = radius_m;
  s.confidence = confidence;
  s.color = {10, 20, 30};
  return s;
}

// Discs in, beside and behind the view, some of them turned away, half of them unstable.
SurfelMap RandomDiscs(int count, float max_radius_m, const Rigid3d& world_from_camera,
                      std::mt19937_64* rng) {
  SurfelMap map;
  for (int i = 0; i < count; ++i) {
    const float z = Uniform(-0.5f, 3, rng);
    const Eigen::Vector3f position(z * Uniform(-0.7f, 0.7f, rng), z * Uniform(-0.5f, 0.5f, rng), z);
    Surfel s = Disc(position, RandomNormal(1.9f, rng), Uniform(0.01f, max_radius_m, rng),
                    Uniform(0, 20, rng), world_from_camera);
    s.color = RandomColor(rng);
    map.Append(s);
  }
  return map;
}

// The documented rule in double precision, for one disc and one pixel.
class DiscAtPixel {
 public:
  DiscAtPixel(const Surfel& s, const PinholeCamera& camera, const Rigid3d& world_from_view, int u,
              int v, const RenderOptions& options) {
    const Rigid3d camera_from_world = world_from_view.Inverse();
    const Eigen::Vector3d p = camera_from_world * s.position_in_world.cast<double>();
    const Eigen::Vector3d n = camera_from_world.rotation * s.normal_in_world.cast<double>();
    stable_ = s.confidence >= options.stable_confidence;
    if (p.z() < 0.05) return;  // kMinDepth
    const Eigen::Vector3d ray = camera.Ray(u, v);
    depth_ = n.dot(p) / n.dot(ray);
    point_ = depth_ * ray;
    const double radius = 1. * options.radius_share * s.radius_m;
    offset_ = (point_ - p).norm() / radius;
    back_ = depth_ + options.surface_thickness_m + 4 * options.noise.SigmaZ(depth_);
    const double window = std::min(camera.fx * radius / p.z(), 1. * options.max_half_window_px);
    const Eigen::Vector2d off = camera.Project(p) - Eigen::Vector2d(u, v);
    // All are positive where the disc covers the pixel.
    margin_ =
        std::min({-n.dot(p.normalized()), depth_, radius / p.z() - (point_ - p).norm() / p.z(),
                  (window - off.lpNorm<Eigen::Infinity>()) / camera.fx});
  }

  // Single precision decides differently only within a few roundings of the limits: the rounding
  // of a position of up to 10 m at 0.05 m or more, on rays that steep discs stretch.
  static constexpr double kEpsilon = 3e-5;
  bool Covers() const { return margin_ > kEpsilon; }
  bool MayCover() const { return margin_ > -kEpsilon; }
  // The other is behind the surface that this one belongs to.
  bool CertainlyHides(const DiscAtPixel& other) const {
    if (stable_ != other.stable_) return stable_;
    return back_ * (1 + kEpsilon) + kEpsilon < other.depth_;
  }
  bool MayHide(const DiscAtPixel& other) const {
    if (stable_ != other.stable_) return stable_;
    return back_ * (1 - kEpsilon) - kEpsilon < other.depth_;
  }
  bool IsCertainlyCloserToTheRay(const DiscAtPixel& other) const {
    return offset_ < other.offset_ - 100 * kEpsilon;
  }
  const Eigen::Vector3d& point() const { return point_; }

 private:
  bool stable_ = false;
  double margin_ = -1;
  double depth_ = 0;
  double back_ = 0;    // of the surface that starts here
  double offset_ = 0;  // share of the radius
  Eigen::Vector3d point_;
};

struct Coverage {
  int drawn = 0;
  int empty = 0;
};

// Holds a view against all discs, pixel by pixel.
Coverage CheckView(const SurfelMap& map, const ModelView& view, const RenderOptions& options) {
  const PinholeCamera& camera = view.surface.camera;
  Coverage coverage;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      std::vector<DiscAtPixel> discs;
      for (std::int32_t id = 0; id < map.id_end(); ++id) {
        const Surfel s = map.Has(id) ? map[id] : Surfel();  // which covers nothing
        discs.emplace_back(s, camera, view.world_from_view, u, v, options);
      }
      const std::int32_t drawn = view.surfel_index(u, v);
      if (drawn == ModelView::kNoSurfel) {
        ++coverage.empty;
        for (const DiscAtPixel& disc : discs) EXPECT_FALSE(disc.Covers()) << u << " " << v;
        continue;
      }
      ++coverage.drawn;
      EXPECT_TRUE(discs.at(drawn).MayCover()) << u << " " << v;
      for (const DiscAtPixel& disc : discs) {
        if (!disc.Covers()) continue;
        EXPECT_FALSE(disc.CertainlyHides(discs[drawn])) << u << " " << v;
        if (!disc.IsCertainlyCloserToTheRay(discs[drawn])) continue;
        // It must be hidden itself.
        EXPECT_TRUE(std::any_of(
            discs.begin(), discs.end(),
            [&](const DiscAtPixel& other) { return other.MayCover() && other.MayHide(disc); }))
            << u << " " << v;
      }
      // On the disc, which may be so steep that its slope multiplies the rounding.
      EXPECT_THAT(view.surface.vertex(u, v).cast<double>(),
                  VectorNear(discs[drawn].point(), 1e-3 * discs[drawn].point().norm()));
    }
  }
  return coverage;
}

TEST(ModelRenderer, DrawsWhatBruteForceFinds) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 6; ++trial) {
    const Rigid3d world_from_view = RandomPose(2, 2, &rng);
    const SurfelMap map = RandomDiscs(trial < 3 ? 300 : 40, 0.2f, world_from_view, &rng);
    RenderOptions options;
    options.radius_share = trial % 2 == 0 ? 0.6f : 1;
    options.max_half_window_px = trial < 3 ? 4 : 20;
    const Coverage coverage =
        CheckView(map, ModelRenderer(options).Render(map, SmallCamera(), world_from_view), options);
    EXPECT_GT(coverage.drawn, 200);
    EXPECT_GT(coverage.empty, 200);
  }
}

// Close to the camera some pixels' rays meet a steep disc's plane behind the camera.
TEST(ModelRenderer, DrawsWhatBruteForceFindsOfLargeDiscsCloseBy) {
  std::mt19937_64 rng(2);
  RenderOptions options;
  options.max_half_window_px = 64;
  for (int trial = 0; trial < 10; ++trial) {
    SurfelMap map;
    for (int i = 0; i < 3; ++i) {
      const float z = Uniform(0.06f, 0.2f, &rng);
      map.Append(Disc({z * Uniform(-0.4f, 0.4f, &rng), z * Uniform(-0.3f, 0.3f, &rng), z},
                      RandomNormal(1.55f, &rng), 0.5f, Uniform(0, 20, &rng)));
    }
    CheckView(map, ModelRenderer(options).Render(map, SmallCamera(), {}), options);
  }
}

TEST(ModelRenderer, WritesTheDiscThatTheIndexNames) {
  std::mt19937_64 rng(3);
  const Rigid3d world_from_view = RandomPose(2, 2, &rng);
  const SurfelMap map = RandomDiscs(500, 0.15f, world_from_view, &rng);
  const PinholeCamera camera = SmallCamera();
  const ModelView view = ModelRenderer({}).Render(map, camera, world_from_view);
  const Image<Rgb8> colors = ColorsOf(view, map);
  EXPECT_EQ(view.surface.camera.width, camera.width);
  EXPECT_EQ(view.world_from_view.Matrix(), world_from_view.Matrix());
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
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
      // The vertex is on its pixel's ray, which is linear in it, so this holds to rounding. Against
      // the plane: positions of up to 5 m in single precision, times a few.
      EXPECT_THAT(camera.Project(vertex), VectorNear(Eigen::Vector2d(u, v), 1e-4));
      const Eigen::Vector3d in_world = world_from_view * vertex;
      const Eigen::Vector3d gap = in_world - map[i].position_in_world.cast<double>();
      EXPECT_NEAR(map[i].normal_in_world.cast<double>().dot(gap), 0, 1e-5);
      EXPECT_LE(gap.norm(), RenderOptions().radius_share * map[i].radius_m + 1e-5);
    }
  }
}

TEST(ModelRenderer, OfAnEmptyMapSeesNothing) {
  const ModelView view = ModelRenderer({}).Render({}, SmallCamera(), {});
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
    return ModelRenderer({}).Render(map, SmallCamera(), {}, active_since).surfel_index;
  };
  EXPECT_THAT(seen(7), ::testing::Contains(0));
  EXPECT_THAT(seen(8), Each(ModelView::kNoSurfel));
}

TEST(ModelRenderer, ForgetsTheViewBefore) {
  SurfelMap map;
  map.Append(Disc({0, 0, 1}, {0, 0, -1}, 0.1f, 20));
  ModelRenderer renderer({});
  EXPECT_THAT(renderer.Render(map, SmallCamera(), {}).surfel_index, ::testing::Contains(0));
  EXPECT_THAT(renderer.Render({}, SmallCamera(), {}).surfel_index, Each(ModelView::kNoSurfel));
  EXPECT_EQ(renderer.Render({}, {5, 3, 60, 60, 2, 1, {}}, {}).surfel_index.size(), 15u);
}

// A wall of surfels, one for each pixel that a camera at the origin sees at this depth.
template <typename Change>
void AppendWall(float depth_m, float confidence, const PinholeCamera& camera, SurfelMap* map,
                const Change& change) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      Surfel surfel = Disc((depth_m * camera.Ray(u, v)).cast<float>(), {0, 0, -1},
                           std::sqrt(2.f) * depth_m / 60, confidence);
      change(&surfel);
      map->Append(surfel);
    }
  }
}

void AppendWall(float depth_m, float confidence, const PinholeCamera& camera, SurfelMap* map) {
  AppendWall(depth_m, confidence, camera, map, [](Surfel*) {});
}

TEST(ModelRenderer, TheNearerOfTwoWallsHidesTheOther) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(2, 20, camera, &map);
  AppendWall(1.5f, 20, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, camera, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 1.5, 1e-6);
}

// The mean depth error of what is drawn of two walls in one place, M surfels in all with noise of
// sigma; most rays meet several.
double MeanErrorOfNoisyWall(float sigma, const RenderOptions& options) {
  const PinholeCamera camera = SmallCamera();
  std::mt19937_64 rng(5);
  std::normal_distribution<float> noise(0, sigma);
  SurfelMap map;
  const auto add_noise = [&](Surfel* s) { s->position_in_world.z() += noise(rng); };
  AppendWall(2, 20, camera, &map, add_noise);
  AppendWall(2, 20, camera, &map, add_noise);
  const ModelView view = ModelRenderer(options).Render(map, camera, {});
  double sum = 0;
  for (const float z : view.surface.vertex.z) sum += z - 2;
  return sum / static_cast<double>(view.surface.vertex.z.size());
}

// The standard error is that of M values, counted as if only a quarter of them were drawn, five
// times which is allowed. If the first disc were always drawn, the nearer of two it would mostly
// be, whose mean is sigma / sqrt(pi) nearer.
TEST(ModelRenderer, NoiseDoesNotMakeSurfacesNearer) {
  constexpr float kSigma = 0.005f;
  EXPECT_NEAR(MeanErrorOfNoisyWall(kSigma, {}), 0, 5 * kSigma / std::sqrt(2 * 64 * 48 / 4));
  RenderOptions first_disc;
  first_disc.surface_thickness_m = 0;
  first_disc.noise.inverse_depth_sigma = 0;
  EXPECT_LT(MeanErrorOfNoisyWall(kSigma, first_disc), -kSigma / std::sqrt(M_PI));
}

TEST(ModelRenderer, AStableWallIsSeenThroughAnUnstableOne) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(1.5f, 0.999f * RenderOptions().stable_confidence, camera, &map);
  const ModelView unstable = ModelRenderer({}).Render(map, camera, {});
  for (const float z : unstable.surface.vertex.z) EXPECT_NEAR(z, 1.5, 1e-6);
  AppendWall(2, RenderOptions().stable_confidence, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, camera, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 2, 1e-6);
}

TEST(ModelRenderer, WhatWasSeenAtDepthEdgesAloneIsNotDrawn) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(1.5f, RenderOptions().stable_confidence, camera, &map,
             [](Surfel* s) { s->at_edge = true; });
  AppendWall(2, RenderOptions().stable_confidence, camera, &map);
  const ModelView view = ModelRenderer({}).Render(map, camera, {});
  for (const float z : view.surface.vertex.z) EXPECT_NEAR(z, 2, 1e-6);
}

// Discs of radius sqrt(2) pixels times 0.6 close the gaps of the grid that they come from, also
// from between its points and from nearer.
TEST(ModelRenderer, AWallMadeFromPixelsHasNoHoles) {
  const PinholeCamera camera = SmallCamera();
  SurfelMap map;
  AppendWall(2, 20, camera, &map);
  for (const double step : {0., 0.01, 0.017, 0.02}) {
    Rigid3d pose(QuaternionExp<double>({0, 0, 10 * step}),
                 Eigen::Vector3d(step, step / 2, 5 * step));
    const ModelView view = ModelRenderer({}).Render(map, camera, pose);
    for (int v = 12; v < 36; ++v) {
      for (int u = 16; u < 48; ++u) {
        EXPECT_NE(view.surfel_index(u, v), ModelView::kNoSurfel) << step << " " << u << " " << v;
      }
    }
  }
}

TEST(ModelRenderer, DoesNotDrawWhatIsTurnedAwayOrBehindTheCamera) {
  SurfelMap map;
  map.Append(Disc({0, 0, 1}, {0, 0, 1}, 0.2f, 20));
  map.Append(Disc({0, 0, -1}, {0, 0, -1}, 0.2f, 20));
  map.Append(Disc({0, 0, -1}, {0, 0, 1}, 0.2f, 20));
  map.Append(Disc({0, 0, 0}, {0, 0, -1}, 0.2f, 20));
  const ModelView view = ModelRenderer({}).Render(map, SmallCamera(), {});
  EXPECT_THAT(view.surfel_index, Each(ModelView::kNoSurfel));
}

TEST(ModelRendererThreads, ViewsAreTheSameBitForBitAtAnyNumberOfThreads) {
  std::mt19937_64 rng(4);
  const Rigid3d pose = RandomPose(2, 2, &rng);
  const SurfelMap map = RandomDiscs(60000, 0.1f, pose, &rng);
  std::vector<ModelView> views;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    views.push_back(ModelRenderer({}).Render(map, SmallCamera(), pose));
  }
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

TEST(RenderOptions, RefuseWhatMakesNoSense) {
  const auto expect_refused = [](auto change, const char* message) {
    RenderOptions options;
    change(options);
    ExpectInputError([&] { options.Validate(); }, HasSubstr(message));
    ExpectInputError([&] { ModelRenderer renderer(options); }, HasSubstr(message));
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  RenderOptions().Validate();
  expect_refused([](auto& o) { o.stable_confidence = -1; },
                 "stable_confidence is -1, must be zero or positive");
  expect_refused([](auto& o) { o.radius_share = 0; }, "radius_share is 0, must be positive");
  expect_refused([](auto& o) { o.radius_share = kNan; }, "radius_share is nan, must be positive");
  expect_refused([](auto& o) { o.max_half_window_px = -1; },
                 "max_half_window_px is -1, must be from 0 to 64");
  expect_refused([](auto& o) { o.max_half_window_px = 65; }, "max_half_window_px is 65");
  expect_refused([](auto& o) { o.surface_thickness_m = -1; },
                 "surface_thickness_m is -1, must be zero or positive");
  expect_refused([](auto& o) { o.noise.inverse_depth_sigma = -1; },
                 "inverse_depth_sigma is -1, must be zero or positive");
}

}  // namespace
}  // namespace surfit
