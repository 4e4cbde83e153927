#include "surfit/mapping/fusion.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "mapping/plane_frame.h"
#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "surfit/core/options.h"
#include "surfit/frame/preprocess.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3f;

TEST(Fusion, FirstFrameBecomesMap) {
  const PinholeCamera camera = TestCamera();
  FrameWithSurface f = WallFrame(camera, {}, 2, 7);
  SetPixel(5, 6, 0, {0, 0, 0}, &f);      // no depth
  SetPixel(10, 20, 1.9, {0, 0, 0}, &f);  // no normal, in front of the wall
  f.frame.color(0, 0) = {1, 2, 3};
  SurfelMap map;
  Fusion fusion({});
  const FusionReport report = Fuse(f, {}, &fusion, &map);
  EXPECT_EQ(report.input_points, 64 * 48 - 2);
  EXPECT_EQ(report.added, 64 * 48 - 2);
  EXPECT_EQ(report.merged, 0);
  EXPECT_EQ(report.removed, 0);
  const Surfel corner = map[0];  // the first surfel
  EXPECT_LT((corner.position_in_world - f.surface.vertex(0, 0)).norm(), kPositionRounding);
  EXPECT_EQ(corner.normal_in_world, Vector3f(0, 0, -1));
  EXPECT_EQ(corner.color, (Rgb8{1, 2, 3}));
  EXPECT_FLOAT_EQ(corner.radius_m, StoredLength(std::sqrt(2.f) * 2 / 80));
  EXPECT_NEAR(corner.confidence, std::exp(-1 / 0.72), kConfidenceRounding);
  EXPECT_EQ(corner.first_seen, 7);
  EXPECT_EQ(corner.last_seen, 7);
}

TEST(Fusion, SameFrameMergesWithoutMotion) {
  const FrameWithSurface f = WallFrame(TestCamera(), {}, 2, 0);
  SurfelMap map;
  Fusion fusion({});
  Fuse(f, {}, &fusion, &map);
  const SurfelMap once = map;
  FrameWithSurface again = f;
  again.frame.index = 1;
  const FusionReport report = Fuse(again, {}, &fusion, &map);
  EXPECT_EQ(report.merged_points, 64 * 48);
  EXPECT_EQ(report.merged, 64 * 48);
  EXPECT_EQ(report.added, 0);
  EXPECT_EQ(report.removed, 0);
  ASSERT_EQ(map.Ids(), once.Ids());
  for (const std::int32_t id : map.Ids()) {
    const Surfel after = map[id], before = once[id];
    EXPECT_FLOAT_EQ(after.position_in_world.x(), before.position_in_world.x());
    EXPECT_FLOAT_EQ(after.position_in_world.z(), before.position_in_world.z());
    EXPECT_EQ(after.color, before.color);
    EXPECT_EQ(after.radius_m, before.radius_m);
    EXPECT_EQ(after.first_seen, before.first_seen);
    EXPECT_FLOAT_EQ(after.confidence, 2 * before.confidence);
    EXPECT_EQ(after.last_seen, 1);
  }
}

TEST(Fusion, UsesGreyWithoutColorAndKeepsColors) {
  FrameWithSurface colored = WallFrame(TestCamera(), {}, 2, 0), plain = colored;
  plain.frame.color = {};
  SurfelMap grey, kept;
  Fusion fusion({});
  Fuse(plain, {}, &fusion, &grey);
  EXPECT_EQ(grey.Color(5), (Rgb8{128, 128, 128}));
  Fuse(colored, {}, &fusion, &kept);
  Fuse(plain, {}, &fusion, &kept);
  EXPECT_EQ(kept.Color(5), (Rgb8{100, 150, 200}));
}

// Black pixels of views have no brightness. Colour is 0.1 s after depth, and the camera moves by
// 0.2 m to the right, so colour does not show the left 8 columns.
TEST(Fusion, UsesBlackOutsideTheColorImage) {
  FrameWithSurface f = WallFrame(TestCamera(), {}, 2, 0);
  f.frame.color_stamp_s = f.frame.stamp_s + 0.1;
  FrameMotion motion;
  motion.camera.velocity_m_per_s.x() = 2;
  SurfelMap map;
  Fusion fusion({});
  fusion.Fuse(f.frame, f.surface, {}, motion, &map);
  int outside = 0;
  for (const std::int32_t id : map.Ids()) {
    const double u = TestCamera().Project(map[id].position_in_world.cast<double>()).x();
    const bool is_outside = u < 7.4;
    if (u > 8.6 || is_outside) {
      EXPECT_EQ(map.Color(id), is_outside ? Rgb8() : (Rgb8{100, 150, 200})) << u;
      EXPECT_EQ(map[id].color_weight == 0, is_outside);
    }
    outside += is_outside;
  }
  EXPECT_EQ(outside, 8 * 48);
}

Rigid3d HandHeldPose(int i) {
  return {QuaternionExp<double>({0.02 * std::sin(0.7 * i), 0.015 * i, 0.01 * i}),
          Eigen::Vector3d(0.015 * i, 0.01 * std::sin(i), -0.012 * i)};
}

// Exact data: the deviation from the plane is the rounding of positions of a few metres, far below
// 1e-5 of the depth.
TEST(Fusion, ExactWallStaysExactWithMovingCamera) {
  SurfelMap map;
  Fusion fusion({});
  for (int i = 0; i < 30; ++i) {
    const Rigid3d pose = HandHeldPose(i);
    const FusionReport report = Fuse(WallFrame(TestCamera(), pose, 2, i), pose, &fusion, &map);
    EXPECT_EQ(report.input_points, 64 * 48);
    EXPECT_EQ(report.merged_points > 0, i > 0);
  }
  for (const std::int32_t id : map.Ids()) {
    EXPECT_NEAR(map[id].position_in_world.z(), 2, 2e-5);
    EXPECT_NEAR(map[id].normal_in_world.x(), 0, 1e-5);
    EXPECT_NEAR(map[id].normal_in_world.y(), 0, 1e-5);
    EXPECT_NEAR(map[id].normal_in_world.z(), -1, 1e-5);
  }
}

// The mean of N exposures with noise sigma has the standard deviation sigma / sqrt(N). The RMS of M
// = W H independent surfels has a relative standard deviation of 1 / sqrt(2 M). The bound is five
// times that.
TEST(Fusion, NoiseDecreasesWithSquareRootOfFrames) {
  const PinholeCamera camera = TestCamera();
  constexpr double kSigma = 0.001;
  constexpr int kFrames = 64;
  Fusion fusion{FusionOptions()};
  SurfelMap map;
  std::mt19937_64 rng(9);
  std::normal_distribution<double> noise(0, kSigma);
  for (int n = 1; n <= kFrames; ++n) {
    FrameWithSurface f = BlankFrame(camera, n);
    for (const auto [u, v] : PixelsOf(camera)) {
      SetPixel(u, v, 2 + noise(rng), {0, 0, -1}, &f);
    }
    Fuse(f, {}, &fusion, &map);
    if (n != 1 && n != 4 && n != 16 && n != kFrames) continue;
    ASSERT_EQ(map.size(), 64u * 48);
    double square_sum = 0;
    for (const std::int32_t id : map.Ids()) {
      const double error = map[id].position_in_world.z() - 2.;
      square_sum += error * error;
    }
    const double rms = std::sqrt(square_sum / (64 * 48)), expected = kSigma / std::sqrt(n);
    EXPECT_NEAR(rms, expected, 5 * expected / std::sqrt(2. * 64 * 48)) << n;
  }
}

// View of a wall with pixels of 2 mm. A new surfel at an even row and column covers the eight
// points around it: all are within sqrt(2) pixels, except for rounding.
TEST(Fusion, NewSurfelsCoverNeighbourPoints) {
  const PinholeCamera camera = {40, 30, 1000, 1000, 19.5, 14.5, {}};
  FusionOptions options;
  Fusion fusion(options);
  SurfelMap map;
  const FusionReport report = Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &map);
  EXPECT_EQ(report.added + report.covered_points, 40 * 30);
  EXPECT_GE(report.added, 20 * 15);      // even rows and columns
  EXPECT_LE(report.added, 2 * 20 * 15);  // plus odd rows and columns, due to rounding
  for (const auto [u, v] : PixelsOf(camera)) {
    const Eigen::Vector3f point = (2 * camera.Ray(u, v)).cast<float>();
    float nearest = 1;
    for (const std::int32_t id : map.Ids()) {
      nearest = std::min(nearest, (map[id].position_in_world - point).norm());
    }
    EXPECT_LE(nearest, 1.0001 * std::sqrt(2) * 0.002 + kPositionRounding);
  }
}

TEST(Fusion, RejectsFrameIndicesThatASurfelCannotStore) {
  Fusion fusion({});
  SurfelMap map;
  FrameWithSurface f = WallFrame(TestCamera(), {}, 2, 0);
  for (const int index : {-1, SurfelBlock::kMaxFrame + 1}) {
    f.frame.index = index;
    ExpectInputError([&] { Fuse(f, {}, &fusion, &map); }, Names(index));
  }
  f.frame.index = SurfelBlock::kMaxFrame;
  Fuse(f, {}, &fusion, &map);
  EXPECT_EQ(map[0].last_seen, SurfelBlock::kMaxFrame);
}

TEST(Fusion, WeightsDependOnCamera) {
  PinholeCamera camera = TestCamera();
  Fusion fusion({});
  SurfelMap map, other;
  Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &map);
  camera.cx = 0;
  camera.cy = 0;
  Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &other);
  EXPECT_EQ(other[0].confidence, 1);
}

TEST(Fusion, RejectsAndCountsSurfelsOfFullMap) {
  const PinholeCamera camera = TestCamera();
  constexpr int kPixels = 64 * 48, kMost = 1000;
  FusionOptions options;
  options.max_map_points = kMost;
  Fusion fusion(options);
  SurfelMap map;
  const FusionReport first = Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &map);
  EXPECT_EQ(first.added, kMost);
  EXPECT_EQ(first.refused, kPixels - kMost);
  const FusionReport second = Fuse(WallFrame(camera, {}, 2, 1), {}, &fusion, &map);
  EXPECT_EQ(second.merged, kMost);
  EXPECT_EQ(second.added, 0);
  EXPECT_EQ(second.merged_points + second.refused, kPixels);
  EXPECT_EQ(map.size(), std::size_t{kMost});
}

TEST(FusionOptions, RejectInvalidValues) {
  const auto expect_refused = [](auto change, const std::string& field, const std::string& value) {
    FusionOptions options;
    change(options);
    ExpectInputError([&] { Validate(options); }, Names(field, value));
    ExpectInputError([&] { Fusion fusion(options); }, Names(field, value));
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Validate(FusionOptions());
  expect_refused([](auto& o) { o.merge_distance_m = 0; }, "merge_distance_m", "0");
  expect_refused([](auto& o) { o.merge_distance_m = kNan; }, "merge_distance_m", "nan");
  expect_refused([](auto& o) { o.merge_angle_rad = 1.6f; }, "merge_angle_rad", "1.6");
  expect_refused([](auto& o) { o.active_frames = -1; }, "active_frames", "-1");
  expect_refused([](auto& o) { o.duplicate_ratio = -1; }, "duplicate_ratio", "-1");
  expect_refused([](auto& o) { o.max_spacing_m = -1; }, "max_spacing_m", "-1");
  expect_refused([](auto& o) { o.max_slant_scale = 0.5f; }, "max_slant_scale", "0.5");
  expect_refused([](auto& o) { o.min_inactive_confidence = -1; }, "min_inactive_confidence", "-1");
  expect_refused([](auto& o) { o.max_inactive_frames = -1; }, "max_inactive_frames", "-1");
  expect_refused([](auto& o) { o.max_map_points = -1; }, "max_map_points", "-1");
  expect_refused([](auto& o) { o.free_space_margin_m = 0; }, "free_space_margin_m", "0");
}

TEST(FusionThreads, MapsAreBitwiseIdenticalAtAnyNumberOfThreads) {
  const PinholeCamera camera{160, 120, 131, 131, 79.5, 59.5, {}};
  const Scene scene = MakeScene("room", 1);
  const Trajectory path = MakePath(scene, 5, 1);
  std::vector<RgbdFrame> frames;
  std::vector<FramePyramid> pyramids;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(RenderFrame(scene, camera, path[i].world_from_camera, i));
    pyramids.push_back(PreprocessDepth(frames.back().depth_m, {camera, {}}, {}));
  }
  const auto maps = AtThreads({1, 2, 4}, [&] {
    Fusion fusion({});
    SurfelMap map;
    for (int i = 0; i < 5; ++i) {
      fusion.Fuse(frames[i], pyramids[i].levels[0], path[i].world_from_camera, &map);
    }
    return map;
  });
  // The map has more than a few cells, so that threads share the work.
  EXPECT_GT(maps[0].cell_count(), 10);
  ExpectSameMap(maps[1], maps[0]);
  ExpectSameMap(maps[2], maps[0]);
}

}  // namespace
}  // namespace surfit::testing
