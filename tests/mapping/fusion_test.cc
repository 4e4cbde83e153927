#include "surfit/mapping/fusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mapping/plane_frame.h"
#include "mapping/same_map.h"
#include "testing/expect_input_error.h"

namespace surfit {
namespace {

using Eigen::Vector3f;
using testing::BlankFrame;
using testing::ExpectConsistent;
using testing::ExpectInputError;
using testing::FrameWithSurface;
using ::testing::HasSubstr;
using testing::SetPixel;
using testing::WallFrame;

PinholeCamera TestCamera() { return {64, 48, 80, 80, 31.5, 23.5, {}}; }

FusionReport Fuse(const FrameWithSurface& f, const Rigid3d& pose, Fusion* fusion, SurfelMap* map) {
  const int before = static_cast<int>(map->size());
  const FusionReport report = fusion->Fuse(f.frame, f.surface, pose, map);
  ExpectConsistent(*map);
  EXPECT_EQ(static_cast<int>(map->size()), before + report.added - report.removed);
  EXPECT_GE(report.covered_points, 0);
  EXPECT_EQ(report.merged_points + report.covered_points + report.added + report.refused,
            report.input_points);
  EXPECT_LE(report.merged, report.merged_points);
  return report;
}

std::vector<float> Confidences(const SurfelMap& map) {
  std::vector<float> confidences;
  for (const std::int32_t id : map.Ids()) confidences.push_back(map[id].confidence);
  return confidences;
}

TEST(Fusion, TheFirstFrameBecomesTheMap) {
  const PinholeCamera camera = TestCamera();
  FrameWithSurface f = WallFrame(camera, {}, 2, 7);
  SetPixel(5, 6, 0, {0, 0, 0}, &f);      // no depth
  SetPixel(10, 20, 1.9, {0, 0, 0}, &f);  // no normal, before the wall
  f.frame.color(0, 0) = {1, 2, 3};
  SurfelMap map;
  Fusion fusion({});
  const FusionReport report = Fuse(f, {}, &fusion, &map);
  EXPECT_EQ(report.input_points, 64 * 48 - 2);
  EXPECT_EQ(report.added, 64 * 48 - 2);
  EXPECT_EQ(report.merged, 0);
  EXPECT_EQ(report.removed, 0);
  const Surfel corner = map[0];  // the first one
  EXPECT_EQ(corner.position_in_world, f.surface.vertex(0, 0));
  EXPECT_EQ(corner.normal_in_world, Vector3f(0, 0, -1));
  EXPECT_EQ(corner.color, (Rgb8{1, 2, 3}));
  EXPECT_FLOAT_EQ(corner.radius_m, std::sqrt(2.f) * 2 / 80);
  EXPECT_FLOAT_EQ(corner.confidence, std::exp(-1 / 0.72f));
  EXPECT_EQ(corner.first_seen, 7);
  EXPECT_EQ(corner.last_seen, 7);
}

TEST(Fusion, TheSameFrameAgainMergesAllAndMovesNothing) {
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

TEST(Fusion, WithoutColorTheMapIsGreyAndKeepsItsColors) {
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

Rigid3d HandHeldPose(int i) {
  return {QuaternionExp<double>({0.02 * std::sin(0.7 * i), 0.015 * i, 0.01 * i}),
          Eigen::Vector3d(0.015 * i, 0.01 * std::sin(i), -0.012 * i)};
}

// Exact data: all that can leave the plane is the rounding of positions of a few metres, far below
// 1e-5 of the depth.
TEST(Fusion, AnExactWallStaysExactUnderAMovingCamera) {
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

// The mean of N exposures with noise of sigma has sigma / sqrt(N); the RMS of M = W H independent
// surfels scatters about that by a share of 1 / sqrt(2 M), five of which are allowed.
TEST(Fusion, NoiseFallsWithTheSquareRootOfTheFrames) {
  const PinholeCamera camera = TestCamera();
  constexpr double kSigma = 0.001;
  constexpr int kFrames = 64;
  for (const char* weighting : {"uniform", "confidence"}) {
    FusionOptions options;
    options.weighting = weighting;
    Fusion fusion(options);
    SurfelMap map;
    std::mt19937_64 rng(9);
    std::normal_distribution<double> noise(0, kSigma);
    for (int n = 1; n <= kFrames; ++n) {
      FrameWithSurface f = BlankFrame(camera, n);
      for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
          SetPixel(u, v, 2 + noise(rng), {0, 0, -1}, &f);
        }
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
      EXPECT_NEAR(rms, expected, 5 * expected / std::sqrt(2. * 64 * 48)) << weighting << " " << n;
    }
  }
}

// One surfel and one measured pixel, the middle one of 5 x 5: whether they meet, at 1 m, where a
// pixel is 1 cm wide.
struct OnePair {
  Surfel surfel;
  FrameWithSurface f = BlankFrame({5, 5, 100, 100, 2, 2, {}}, 3);
  FusionOptions options;

  OnePair() {
    surfel.position_in_world = {0, 0, 1};
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = std::sqrt(2.f) / 100;
    surfel.confidence = 4;
    surfel.first_seen = surfel.last_seen = 2;
    SetPixel(2, 2, 1, {0, 0, -1}, &f);
  }

  FusionReport Run(SurfelMap* map) const {
    map->Append(surfel);
    Fusion fusion(options);
    const FusionReport report = Fuse(f, {}, &fusion, map);
    EXPECT_EQ(report.input_points, 1);
    EXPECT_EQ(report.removed, 0);
    return report;
  }
  bool Merges() const {
    SurfelMap map;
    const bool merged = Run(&map).merged_points == 1;
    EXPECT_EQ(map.size(), merged ? 1u : 2u);
    return merged;
  }
};

TEST(FusionGates, DistanceAlongTheNormal) {
  for (const float sign : {-1.f, 1.f}) {
    OnePair pair;
    pair.surfel.position_in_world.z() = 1 + sign * 0.0499f;
    EXPECT_TRUE(pair.Merges());
    pair.surfel.position_in_world.z() = 1 + sign * 0.0501f;
    EXPECT_FALSE(pair.Merges());
    pair.options.max_distance_m = 0.06f;
    EXPECT_TRUE(pair.Merges());
  }
}

TEST(FusionGates, AngleBetweenTheNormals) {
  OnePair pair;
  const auto tilt = [&](float angle) {
    pair.surfel.normal_in_world = {0, std::sin(angle), -std::cos(angle)};
  };
  tilt(0.599f);
  EXPECT_TRUE(pair.Merges());
  tilt(0.601f);
  EXPECT_FALSE(pair.Merges());
  pair.options.max_normal_angle_rad = 0.7f;
  EXPECT_TRUE(pair.Merges());
}

TEST(FusionGates, DistanceAcrossIsTheSpacingOrTheRadius) {
  OnePair pair;
  pair.options.max_spacing_m = 0.003f;  // below half a pixel, so that the pixel stays the same
  pair.surfel.position_in_world.x() = 0.00299f;
  EXPECT_TRUE(pair.Merges());
  pair.surfel.position_in_world.x() = 0.00301f;
  EXPECT_FALSE(pair.Merges());

  // Finer pixels: the point's radius of sqrt(2) / 1000 rules where it is below the spacing. Beyond
  // the pixel itself another measured one must have taken the surfel.
  OnePair fine;
  fine.f = BlankFrame({5, 5, 1000, 1000, 2, 2, {}}, 3);
  SetPixel(2, 2, 1, {0, 0, -1}, &fine.f);
  fine.options.max_spacing_m = 1;
  fine.surfel.normal_in_world = Vector3f(0, 0.5f, -1).normalized();
  // A surfel behind the pixel's centre by h is (n_y h, n_z h) = 0.447 h across.
  fine.surfel.position_in_world = {0, 0, 1 + 0.0014f / 0.4472f};
  EXPECT_TRUE(fine.Merges());
  fine.surfel.position_in_world = {0, 0, 1 + 0.0015f / 0.4472f};
  EXPECT_FALSE(fine.Merges());
}

TEST(FusionGates, CoarsePointsDoNotMoveAFineSurfel) {
  OnePair pair;
  pair.surfel.position_in_world.z() = 1.01f;
  pair.surfel.radius_m = 0.0142f / 1.49f;
  SurfelMap fine_enough, too_coarse;
  EXPECT_EQ(pair.Run(&fine_enough).merged, 1);
  EXPECT_NEAR(fine_enough[0].position_in_world.z(), 1.01 - 0.01 / 5, 1e-6);
  EXPECT_EQ(fine_enough[0].radius_m, pair.surfel.radius_m);

  pair.surfel.radius_m = 0.0141f / 1.51f;
  EXPECT_EQ(pair.Run(&too_coarse).merged, 1);
  EXPECT_EQ(too_coarse[0].position_in_world.z(), 1.01f);
  EXPECT_EQ(too_coarse[0].confidence, 5);
  EXPECT_EQ(too_coarse[0].last_seen, 3);
  EXPECT_EQ(too_coarse[0].first_seen, 2);
}

TEST(FusionGates, AFinerPointShrinksTheSurfel) {
  OnePair pair;
  pair.surfel.radius_m = 0.05f;
  SurfelMap map;
  pair.Run(&map);
  EXPECT_FLOAT_EQ(map[0].radius_m, std::sqrt(2.f) / 100);
}

TEST(FusionGates, TheNearestOfTwoSurfelsIsTaken) {
  OnePair pair;
  pair.options.double_share = 0;
  SurfelMap map;
  Surfel other = pair.surfel;
  other.position_in_world.z() = 0.99f;
  map.Append(other);
  other.position_in_world.z() = 1.02f;
  map.Append(other);
  pair.surfel.position_in_world.z() = 1.005f;
  pair.Run(&map);
  EXPECT_EQ(Confidences(map), (std::vector<float>{4, 4, 5}));
}

// A view of a wall with pixels of 2 mm: the first surfel, of an even row and column, stands for the
// eight points around, all within sqrt(2) pixels but for rounding, and so do the others.
TEST(Fusion, NewSurfelsStandForThePointsBesideThem) {
  const PinholeCamera camera = {40, 30, 1000, 1000, 19.5, 14.5, {}};
  FusionOptions options;
  Fusion fusion(options);
  SurfelMap map;
  const FusionReport report = Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &map);
  EXPECT_EQ(report.added + report.covered_points, 40 * 30);
  EXPECT_GE(report.added, 20 * 15);      // even rows and columns
  EXPECT_LE(report.added, 2 * 20 * 15);  // and odd ones, where rounding says so
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3f point = (2 * camera.Ray(u, v)).cast<float>();
      float nearest = 1;
      for (const std::int32_t id : map.Ids()) {
        nearest = std::min(nearest, (map[id].position_in_world - point).norm());
      }
      EXPECT_LE(nearest, 1.0001f * std::sqrt(2.f) * 0.002f);
    }
  }
}

// Two surfels of one pixel or of two that are side by side, 4 mm apart with radii of sqrt(2) cm.
TEST(FusionDoubles, TheOneOfLessConfidenceGoes) {
  for (const float x : {0.f, 0.004f}) {  // a pixel's border is at 5 mm
    OnePair pair;
    SetPixel(3, 2, 1, {0, 0, -1}, &pair.f);
    Surfel other = pair.surfel;
    pair.surfel.position_in_world.x() = x;
    other.position_in_world.x() = x + 0.004f;
    other.confidence = 7;
    SurfelMap map;
    map.Append(pair.surfel);
    map.Append(other);
    Fusion fusion(pair.options);
    EXPECT_EQ(Fuse(pair.f, {}, &fusion, &map).removed, 1);
    ASSERT_EQ(map.size(), 1u);
    EXPECT_GE(map[0].confidence, 7);
  }
}

TEST(FusionDoubles, OnesThatAreFartherApartOrTurnedAwayStay) {
  const auto removed = [](const Surfel& other, float double_share) {
    OnePair pair;
    pair.options.double_share = double_share;
    SurfelMap map;
    map.Append(pair.surfel);
    map.Append(other);
    Fusion fusion(pair.options);
    return Fuse(pair.f, {}, &fusion, &map).removed;
  };
  Surfel other = OnePair().surfel;
  other.confidence = 7;
  other.position_in_world.x() = 0.0049f;  // the spacing, 1 cm, is less than the radii
  EXPECT_EQ(removed(other, 0.5f), 1);
  EXPECT_EQ(removed(other, 0.48f), 0);
  EXPECT_EQ(removed(other, 0), 0);
  other.radius_m = 0.009f;
  EXPECT_EQ(removed(other, 0.5f), 0);
  other.radius_m = 0.02f;
  other.position_in_world.z() = 1.049f;
  EXPECT_EQ(removed(other, 0.5f), 1);
  other.position_in_world.z() = 1.051f;
  EXPECT_EQ(removed(other, 0.5f), 0);
  other.position_in_world.z() = 1;
  other.normal_in_world = {0, std::sin(0.61f), -std::cos(0.61f)};
  EXPECT_EQ(removed(other, 0.5f), 0);
}

// Two pixels, one surfel in the first one: the second point has none of its own and takes it.
TEST(FusionGates, APointTakesTheSurfelOfItsNeighbourWithinReach) {
  OnePair pair;
  pair.options.weighting = "uniform";
  pair.options.max_spacing_m = 0.0125f;
  SetPixel(3, 2, 1, {0, 0, -1}, &pair.f);
  SurfelMap map;
  map.Append(pair.surfel);
  Fusion fusion(pair.options);
  const FusionReport report = Fuse(pair.f, {}, &fusion, &map);
  EXPECT_EQ(report.merged_points, 2);
  EXPECT_EQ(report.merged, 1);
  EXPECT_EQ(report.added, 0);
  EXPECT_EQ(map[0].confidence, 6);
  EXPECT_NEAR(map[0].position_in_world.x(), 0.01 / 6, 1e-7);

  pair.options.max_spacing_m = 0.0075f;
  Fusion tighter(pair.options);
  SurfelMap two;
  two.Append(pair.surfel);
  EXPECT_EQ(Fuse(pair.f, {}, &tighter, &two).added, 1);
}

TEST(FusionDormancy, SurfelsOfLowConfidenceGoWhenNotSeenForLongerThanAllowed) {
  FusionOptions options;
  options.max_dormant_frames = 5;
  Fusion fusion(options);
  SurfelMap map;
  Surfel s;  // behind the camera
  s.position_in_world = {0, 0, -1};
  s.normal_in_world = {0, 0, -1};
  s.radius_m = 0.01f;
  s.confidence = 0.999f * options.lasting_confidence;
  map.Append(s);
  s.confidence = options.lasting_confidence;
  map.Append(s);
  for (int i = 1; i <= 5; ++i) {
    EXPECT_EQ(Fuse(BlankFrame(TestCamera(), i), {}, &fusion, &map).removed, 0) << i;
  }
  EXPECT_EQ(Fuse(BlankFrame(TestCamera(), 6), {}, &fusion, &map).removed, 1);
  EXPECT_EQ(Confidences(map), std::vector<float>{options.lasting_confidence});
  for (int i = 7; i < 100; ++i) Fuse(BlankFrame(TestCamera(), i), {}, &fusion, &map);
  EXPECT_EQ(map.size(), 1u);
}

// A sequence of which every 30th frame is used, or a long one that was lost, must not empty the
// map: what counts is how often fusion had the chance to see a surfel again.
TEST(FusionDormancy, CountsTheFramesThatWereFused) {
  Fusion fusion({});
  SurfelMap map;
  for (int i = 0; i < 5; ++i) {
    const FusionReport report = Fuse(WallFrame(TestCamera(), {}, 2, 30 * i), {}, &fusion, &map);
    EXPECT_EQ(report.removed, 0);
    EXPECT_EQ(report.merged_points, i == 0 ? 0 : 64 * 48);
  }
}

// A wall, then nothing for some frames, then the wall again.
TEST(FusionActiveFrames, WhatWasNotSeenInTheWindowIsMappedOnceMore) {
  for (const int active_frames : {0, 3, 4}) {
    FusionOptions options;
    options.active_frames = active_frames;
    Fusion fusion(options);
    SurfelMap map;
    Fuse(WallFrame(TestCamera(), {}, 2, 0), {}, &fusion, &map);
    for (int i = 1; i <= 3; ++i) Fuse(BlankFrame(TestCamera(), i), {}, &fusion, &map);
    EXPECT_EQ(fusion.ActiveSince() > 0, false) << active_frames;
    const FusionReport again = Fuse(WallFrame(TestCamera(), {}, 2, 4), {}, &fusion, &map);
    EXPECT_EQ(fusion.ActiveSince() > 0, active_frames == 3);
    EXPECT_EQ(again.added, active_frames == 3 ? 64 * 48 : 0) << active_frames;
    EXPECT_EQ(again.merged_points, active_frames == 3 ? 0 : 64 * 48) << active_frames;
  }
}

// A patch of 5 x 5 surfels about the ray of pixel (32, 24), in front of a wall at 2 m.
struct FloatingPatch {
  SurfelMap map;
  FrameWithSurface f = WallFrame(TestCamera(), {}, 2, 1);

  explicit FloatingPatch(float depth_m) {
    Surfel s;
    s.normal_in_world = {0, 0, -1};
    s.radius_m = 0.02f;
    s.confidence = 50;
    for (int v = -2; v <= 2; ++v) {
      for (int u = -2; u <= 2; ++u) {
        s.position_in_world = (depth_m * TestCamera().Ray(32 + u, 24 + v)).cast<float>();
        map.Append(s);
      }
    }
  }
  int Removed(const FusionOptions& options = {}) {
    Fusion fusion(options);
    return Fuse(f, {}, &fusion, &map).removed;
  }
};

TEST(FusionFreeSpace, WhatIsSeenThroughIsRemovedEvenIfStable) {
  FloatingPatch patch(1);
  EXPECT_EQ(patch.Removed(), 25);
  for (const std::int32_t id : patch.map.Ids()) {
    EXPECT_NEAR(patch.map[id].position_in_world.z(), 2, 1e-6);
  }
}

// All 25 pixels see the missing one but those more than a pixel off.
TEST(FusionFreeSpace, WhereSomeDepthAroundIsMissingNothingIsRemoved) {
  FloatingPatch patch(1);
  patch.f.frame.depth_m(32, 24) = 0;
  EXPECT_EQ(patch.Removed(), 25 - 9);
}

TEST(FusionFreeSpace, TheMarginIsFiveCentimetresAndFourSigmas) {
  const float border = 2 - 0.05f - 4 * 0.002f * 4;
  EXPECT_EQ(FloatingPatch(border - 0.001f).Removed(), 25);
  EXPECT_EQ(FloatingPatch(border + 0.001f).Removed(), 0);
  FusionOptions wider;
  wider.free_space_margin_m = 0.2f;
  EXPECT_EQ(FloatingPatch(border - 0.001f).Removed(wider), 0);
}

TEST(FusionFreeSpace, WhatIsHiddenStays) { EXPECT_EQ(FloatingPatch(3).Removed(), 0); }

TEST(Fusion, WeightsFollowTheCamera) {
  PinholeCamera camera = TestCamera();
  Fusion fusion({});
  SurfelMap map, other;
  Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &map);
  camera.cx = 0;
  camera.cy = 0;
  Fuse(WallFrame(camera, {}, 2, 0), {}, &fusion, &other);
  EXPECT_EQ(other[0].confidence, 1);
}

TEST(Fusion, AFullMapRefusesSurfelsAndCountsThem) {
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

TEST(FusionOptions, RefuseWhatMakesNoSense) {
  const auto expect_refused = [](auto change, const char* message) {
    FusionOptions options;
    change(options);
    ExpectInputError([&] { options.Validate(); }, HasSubstr(message));
    ExpectInputError([&] { Fusion fusion(options); }, HasSubstr(message));
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  FusionOptions().Validate();
  expect_refused([](auto& o) { o.weighting = "best"; },
                 "weighting is 'best', must be one of: confidence, uniform");
  expect_refused([](auto& o) { o.max_distance_m = 0; }, "max_distance_m is 0, must be positive");
  expect_refused([](auto& o) { o.max_distance_m = kNan; }, "max_distance_m is nan");
  expect_refused([](auto& o) { o.max_normal_angle_rad = 1.6f; },
                 "max_normal_angle_rad is 1.6, must be positive and below pi/2");
  expect_refused([](auto& o) { o.active_frames = -1; },
                 "active_frames is -1, must be zero or positive");
  expect_refused([](auto& o) { o.double_share = -1; },
                 "double_share is -1, must be zero or positive");
  expect_refused([](auto& o) { o.max_spacing_m = -1; }, "max_spacing_m is -1, must be positive");
  expect_refused([](auto& o) { o.max_slant_scale = 0.5f; },
                 "max_slant_scale is 0.5, must be at least 1");
  expect_refused([](auto& o) { o.max_radius_ratio = 0; }, "max_radius_ratio is 0");
  expect_refused([](auto& o) { o.lasting_confidence = -1; }, "lasting_confidence is -1");
  expect_refused([](auto& o) { o.max_dormant_frames = -1; },
                 "max_dormant_frames is -1, must be zero or positive");
  expect_refused([](auto& o) { o.max_confidence = 0; }, "max_confidence is 0, must be positive");
  expect_refused([](auto& o) { o.max_map_points = -1; },
                 "max_map_points is -1, must be zero (no limit) or positive");
  expect_refused([](auto& o) { o.free_space_margin_m = 0; }, "free_space_margin_m is 0");
  expect_refused([](auto& o) { o.noise.inverse_depth_sigma = -1; },
                 "inverse_depth_sigma is -1, must be zero or positive");
}

}  // namespace
}  // namespace surfit
