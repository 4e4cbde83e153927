// Tests of the removal of dormant surfels and of free-space violations, and of inactive surfels.
#include <gtest/gtest.h>

#include "mapping/plane_frame.h"

namespace surfit::testing {
namespace {

TEST(FusionDormancy, RemovesUnstableSurfelsAfterMaxDormantFrames) {
  FusionOptions options;
  options.max_inactive_frames = 5;
  Fusion fusion(options);
  SurfelMap map;
  Surfel s;  // behind the camera
  s.position_in_world = {0, 0, -1};
  s.normal_in_world = {0, 0, -1};
  s.radius_m = 0.01f;
  s.confidence = options.min_inactive_confidence - 2 * kConfidenceRounding;  // one step
  map.Append(s);
  s.confidence = options.min_inactive_confidence;
  map.Append(s);
  for (int i = 1; i <= 5; ++i) {
    EXPECT_EQ(Fuse(BlankFrame(TestCamera(), i), {}, &fusion, &map).removed, 0) << i;
  }
  EXPECT_EQ(Fuse(BlankFrame(TestCamera(), 6), {}, &fusion, &map).removed, 1);
  EXPECT_EQ(Confidences(map), std::vector<float>{options.min_inactive_confidence});
  for (int i = 7; i < 100; ++i) Fuse(BlankFrame(TestCamera(), i), {}, &fusion, &map);
  EXPECT_EQ(map.size(), 1u);
}

// Frames that are not fused do not count. So the map is kept if only every 30th frame is fused, or
// after a long loss.
TEST(FusionDormancy, CountsFusedFramesOnly) {
  Fusion fusion({});
  SurfelMap map;
  for (int i = 0; i < 5; ++i) {
    const FusionReport report = Fuse(WallFrame(TestCamera(), {}, 2, 30 * i), {}, &fusion, &map);
    EXPECT_EQ(report.removed, 0);
    EXPECT_EQ(report.merged_points, i == 0 ? 0 : 64 * 48);
  }
}

TEST(FusionActiveFrames, MapsInactiveSurfacesAgain) {
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

// Patch of 5 x 5 surfels around the ray of pixel (32, 24), in front of a wall at 2 m.
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

TEST(FusionFreeSpace, RemovesStableSurfelsInFreeSpace) {
  FloatingPatch patch(1);
  EXPECT_EQ(patch.Removed(), 25);
  for (const std::int32_t id : patch.map.Ids()) {
    EXPECT_NEAR(patch.map[id].position_in_world.z(), 2, 1e-6);
  }
}

TEST(FusionFreeSpace, KeepsSurfelsNextToMissingDepth) {
  FloatingPatch patch(1);
  patch.f.frame.depth_m(32, 24) = 0;
  EXPECT_EQ(patch.Removed(), 25 - 9);
}

TEST(FusionFreeSpace, MarginIsFiveCentimetresPlusFourSigmas) {
  const float border = 2 - 0.05f - 4 * 0.002f * 4;
  EXPECT_EQ(FloatingPatch(border - 0.001f).Removed(), 25);
  EXPECT_EQ(FloatingPatch(border + 0.001f).Removed(), 0);
  FusionOptions wider;
  wider.free_space_margin_m = 0.2f;
  EXPECT_EQ(FloatingPatch(border - 0.001f).Removed(wider), 0);
}

TEST(FusionFreeSpace, KeepsOccludedSurfels) { EXPECT_EQ(FloatingPatch(3).Removed(), 0); }

}  // namespace
}  // namespace surfit::testing
