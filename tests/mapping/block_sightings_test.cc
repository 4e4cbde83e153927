#include <gtest/gtest.h>

#include <random>

#include "mapping/map/block_observations.h"

namespace surfit::testing {
namespace {

constexpr float kMaxConfidence = 20;

class BlockSightingsTest : public ::testing::Test {
 protected:
  float Uniform(float from, float to) {
    return std::uniform_real_distribution<float>(from, to)(random_);
  }
  bool Chance(float share) { return Uniform(0, 1) < share; }
  Eigen::Vector3f Vector(float from, float to) {
    const float x = Uniform(from, to), y = Uniform(from, to), z = Uniform(from, to);
    return {x, y, z};
  }

  SurfelBlock Block(int count) {
    SurfelBlock block;
    block.count = count;
    for (int k = 0; k < count; ++k) {
      Surfel surfel;
      surfel.position_in_world = Vector(-0.4f, 0.4f);
      surfel.normal_in_world = Vector(-1, 1).normalized();
      surfel.radius_m = Uniform(0.001f, 0.02f);
      surfel.confidence = Uniform(0.1f, kMaxConfidence);
      surfel.at_edge = Chance(0.3f);
      surfel.color = ToRgb8(Vector(0, 255));
      surfel.color_weight = Chance(0.2f) ? 0 : Uniform(0, 30);
      block.Write(k, surfel);
      block.Announce(k, surfel);
    }
    return block;
  }

  SurfelObservation Observation() {
    SurfelObservation seen;
    seen.position_in_world = Vector(-0.4f, 0.4f);
    seen.normal_in_world = 0.9f * Vector(-1, 1).normalized();
    seen.radius_m = Uniform(0.001f, 0.02f);
    seen.weight = Uniform(0.3f, 5);
    seen.shape_weight = Chance(0.3f) ? 0 : seen.weight;
    seen.color = Vector(0, 255);
    seen.color_weight = Chance(0.3f) ? 0 : Uniform(0.01f, 3);
    seen.at_edge = Chance(0.3f);
    return seen;
  }

  std::mt19937_64 random_{1};
};

void ExpectSame(const SurfelBlock& a, const SurfelBlock& b) {
  EXPECT_EQ(a.at_edge, b.at_edge);
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
    EXPECT_EQ(a[k].position_in_world, b[k].position_in_world) << k;
    EXPECT_EQ(a[k].normal_in_world, b[k].normal_in_world) << k;
    EXPECT_EQ(a.radius[k], b.radius[k]) << k;
    EXPECT_EQ(a.confidence[k], b.confidence[k]) << k;
    EXPECT_EQ(a.red[k], b.red[k]) << k;
    EXPECT_EQ(a.green[k], b.green[k]) << k;
    EXPECT_EQ(a.blue[k], b.blue[k]) << k;
  }
}

TEST_F(BlockSightingsTest, AgreesWithMergeOfSingleSurfels) {
  BlockObservations sightings;
  for (const int count : {1, 7, 63, 64}) {
    SurfelBlock block = Block(count), expected = block;
    sightings.Clear();
    EXPECT_TRUE(sightings.empty());
    for (int k = 0; k < count; ++k) {
      if (count > 1 && Chance(0.4f)) continue;
      const SurfelObservation seen = Observation();
      sightings.Add(k, seen);
      expected.Merge(k, seen, kMaxConfidence);
    }
    EXPECT_FALSE(sightings.empty());
    sightings.MergeInto(&block, kMaxConfidence);
    ExpectSame(block, expected);
  }
}

}  // namespace
}  // namespace surfit::testing
