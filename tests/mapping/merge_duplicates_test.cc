#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "surfit/core/parallel.h"
#include "surfit/mapping/fusion.h"

namespace surfit::testing {
namespace {

constexpr int kApart = 100;        // frames
constexpr float kSpacing = 0.01f;  // between the surfels of a wall
constexpr float kRadius = 0.01f;
constexpr int kSide = 40;

// Adds a wall at this depth, shifted along itself and observed in ten frames starting with `first`.
void AddWall(float depth_m, float shift_m, int first, float confidence, SurfelMap* map) {
  for (int i = 0; i < kSide * kSide; ++i) {
    Surfel surfel;
    surfel.position_in_world = {kSpacing * (i % kSide) + shift_m, kSpacing * (i / kSide), depth_m};
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = kRadius;
    surfel.confidence = confidence;
    surfel.first_seen = first;
    surfel.last_seen = first + 10;
    map->Append(surfel);
  }
}

constexpr std::size_t kWall = kSide * kSide;

TEST(MergeDuplicates, MergesTwoWalls) {
  SurfelMap map;
  AddWall(2, 0, 0, 3, &map);
  AddWall(2.02f, 0.3f * kSpacing, 500, 1, &map);
  EXPECT_EQ(MergeDuplicates({}, {kApart}, &map), kWall);
  ASSERT_EQ(map.size(), kWall);
  ExpectConsistent(map);
  for (const std::int32_t id : map.Ids()) {
    EXPECT_NEAR(map[id].position_in_world.z(), (3 * 2 + 1 * 2.02) / 4, 2 * kPositionRounding);
    EXPECT_EQ(map[id].confidence, 4);
    EXPECT_EQ(map[id].first_seen, 0);
    EXPECT_EQ(map[id].last_seen, 510);
  }
}

// Walls far from each other, and a surfel that was merged to the limit of its cell's margin.
TEST(MergeDuplicates, FindsDuplicatesInCellsOfAnySize) {
  SurfelMap map;
  for (const float shift_m : {-900.f, -3.f, 0.3f, 12.f, 900.f}) {
    AddWall(2, shift_m, 0, 3, &map);
    AddWall(2.02f, shift_m, 500, 1, &map);
  }
  Surfel stray;
  stray.normal_in_world = {0, 0, -1};
  stray.radius_m = kRadius;
  stray.confidence = 1;
  stray.position_in_world = {40, 40, 40};
  const std::int32_t id = map.Append(stray);
  SurfelObservation far;
  far.position_in_world = {50, 50, 50};
  far.normal_in_world = {0, 0, -1};
  far.radius_m = kRadius;
  far.weight = far.shape_weight = 1e6f;
  map.Merge(id, far, 10);
  Surfel again = stray;
  again.position_in_world = map[id].position_in_world;
  again.first_seen = again.last_seen = 500;
  map.Append(again);
  EXPECT_EQ(MergeDuplicates({}, {kApart}, &map), 5 * kWall + 1);
  ExpectConsistent(map);
}

TEST(MergeDuplicates, MergesThreeWalls) {
  SurfelMap map;
  AddWall(2, 0, 0, 1, &map);
  AddWall(2.01f, 0, 500, 1, &map);
  AddWall(2.03f, 0, 1000, 1, &map);
  EXPECT_EQ(MergeDuplicates({}, {kApart}, &map), 2 * kWall);
  for (const std::int32_t id : map.Ids()) {
    EXPECT_NEAR(map[id].position_in_world.z(), (2 + 2.01 + 2.03) / 3, 2 * kPositionRounding);
  }
}

TEST(MergeDuplicates, KeepsSurfelsThatDoNotOverlap) {
  struct Case {
    const char* name;
    float depth_m, shift_m;
    int first;
  };
  const float gate = FusionOptions().merge_distance_m;
  for (const Case& c : {Case{"another wall", 2 + 1.1f * gate, 0, 500},
                        Case{"its continuation", 2, kSpacing * kSide + kRadius, 500},
                        Case{"fused at the time", 2.02f, 0, 10 + kApart}}) {
    SurfelMap map;
    AddWall(2, 0, 0, 1, &map);
    AddWall(c.depth_m, c.shift_m, c.first, 1, &map);
    EXPECT_EQ(MergeDuplicates({}, {kApart}, &map), 0u) << c.name;
    EXPECT_EQ(map.size(), 2 * kWall) << c.name;
  }
}

TEST(MergeDuplicates, RespectsFirstFrameOfOptions) {
  SurfelMap map;
  AddWall(2, 0, 0, 1, &map);
  AddWall(2.02f, 0, 500, 1, &map);
  EXPECT_EQ(MergeDuplicates({}, {kApart, 501}, &map), 0u);
  EXPECT_EQ(MergeDuplicates({}, {kApart, 500}, &map), kWall);
}

TEST(MergeDuplicates, KeepsBackSideOfBoard) {
  SurfelMap map;
  AddWall(2, 0, 0, 1, &map);
  Surfel behind;
  behind.position_in_world = {0.1f, 0.1f, 2.01f};
  behind.normal_in_world = {0, 0, 1};
  behind.radius_m = kRadius;
  behind.confidence = 1;
  behind.first_seen = behind.last_seen = 500;
  map.Append(behind);
  EXPECT_EQ(MergeDuplicates({}, {kApart}, &map), 0u);
}

// Brute force: each newer surfel merges if an older surfel passes the gates.
TEST(MergeDuplicates, AgreesWithBruteForce) {
  std::mt19937_64 rng(3);
  SurfelMap map;
  for (int i = 0; i < 2000; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.1f;
    surfel.first_seen = 1000 * (i % 2);
    surfel.last_seen = surfel.first_seen + 5;
    map.Append(surfel);
  }
  std::size_t expected = 0;
  const FusionOptions options;
  for (const std::int32_t b : map.Ids()) {
    bool has_older = false;
    for (const std::int32_t a : map.Ids()) {
      const Surfel old = map[a], seen = map[b];
      if (seen.first_seen - old.last_seen <= kApart) continue;
      const Eigen::Vector3f gap = seen.position_in_world - old.position_in_world;
      const float along = gap.dot(seen.normal_in_world);
      const float across = std::sqrt(std::max(0.f, gap.squaredNorm() - along * along));
      has_older |=
          std::abs(along) <= options.merge_distance_m &&
          across <= std::min(seen.radius_m, options.max_spacing_m) &&
          old.normal_in_world.dot(seen.normal_in_world) >= std::cos(options.merge_angle_rad);
    }
    expected += has_older;
  }
  EXPECT_GT(expected, 20u);
  EXPECT_EQ(MergeDuplicates(options, {kApart}, &map), expected);
}

TEST(MergeDoublesThreads, AreBitwiseIdentical) {
  const auto merged = [](int threads) {
    const ThreadLimit limit(threads);
    SurfelMap map;
    AddWall(2, 0, 0, 3, &map);
    AddWall(2.02f, 0.3f * kSpacing, 500, 1, &map);
    AddWall(2.01f, 0.1f * kSpacing, 900, 1, &map);
    MergeDuplicates({}, {kApart}, &map);
    return map;
  };
  const SurfelMap one = merged(1);
  ExpectSameMap(merged(2), one);
  ExpectSameMap(merged(4), one);
}

}  // namespace
}  // namespace surfit::testing
