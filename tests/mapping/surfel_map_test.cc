#include "surfit/mapping/surfel_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::ExpectConsistent;
using testing::ExpectSameMap;
using testing::RandomColor;
using testing::RandomNormal;
using testing::RandomSurfel;
using testing::Uniform;
using testing::VectorNear;

constexpr float kNoCap = 1e9f;
constexpr double kUlp = 6e-8;  // relative rounding of a float, 2^-24

auto AsTuple(const Surfel& s) {
  const auto& p = s.position_in_world;
  const auto& n = s.normal_in_world;
  return std::make_tuple(p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), s.color.r, s.color.g, s.color.b,
                         s.radius_m, s.confidence, s.first_seen, s.last_seen, s.at_edge);
}

Eigen::Vector3d ColorAsVector(Rgb8 color) { return {1. * color.r, 1. * color.g, 1. * color.b}; }

SurfelObservation RandomObservation(std::mt19937_64* rng) {
  SurfelObservation seen;
  for (float& x : seen.position_in_world) x = Uniform(-3, 3, rng);
  seen.normal_in_world = RandomNormal(0.5f, rng);
  seen.color = ColorAsVector(RandomColor(rng)).cast<float>();
  seen.radius_m = Uniform(0.001f, 0.02f, rng);
  seen.weight = seen.shape_weight = seen.color_weight = Uniform(0.2f, 1, rng);
  return seen;
}

// The stored colour in steps of a byte.
Eigen::Vector3d StoredColor(const SurfelMap& map, std::int32_t id) {
  const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
  const int k = id % SurfelBlock::kCapacity;
  return Eigen::Vector3d(block.red[k], block.green[k], block.blue[k]) / 256;
}

TEST(SurfelMap, GivesBackWhatWasAppended) {
  std::mt19937_64 rng(1);
  SurfelMap map;
  EXPECT_EQ(map.size(), 0u);
  std::vector<Surfel> surfels;
  std::vector<std::int32_t> ids;
  for (int i = 0; i < 100; ++i) {
    surfels.push_back(RandomSurfel(&rng));
    ids.push_back(map.Append(surfels.back()));
  }
  ExpectConsistent(map);
  ASSERT_EQ(map.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(AsTuple(map[ids[i]]), AsTuple(surfels[i])) << i;
  EXPECT_THAT(map.Ids(), ::testing::UnorderedElementsAreArray(ids));
  SurfelMap at_once;
  at_once.Append(surfels);
  ExpectSameMap(at_once, map);
}

TEST(SurfelMap, KeepsSurfelsOfOneCellTogether) {
  std::mt19937_64 rng(9);
  SurfelMap map;
  for (int i = 0; i < 5000; ++i) map.Append(RandomSurfel(&rng));
  EXPECT_LE(map.cell_count(), 13 * 13 * 13);  // half a cell at each end of the 6 m
  ExpectConsistent(map);
  for (std::int32_t c = 0; c < map.cell_count(); ++c) {
    const SurfelBounds& bounds = map.cell(c).bounds;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(bounds.high[axis] - bounds.low[axis], SurfelMap::kCellSize);
    }
  }
}

// One that fusion has made of noise, far outside of the world, costs nothing but its cell.
TEST(SurfelMap, TakesPositionsFarOutside) {
  SurfelMap map;
  Surfel s;
  for (const float x : {-1e30f, 1e30f, 1e6f}) {
    s.position_in_world = {x, 0, -x};
    EXPECT_EQ(map[map.Append(s)].position_in_world, s.position_in_world);
  }
  ExpectConsistent(map);
}

// Blocks are full but for the last of each cell, so that a map of a thousand surfels to the cell,
// which is few, needs little more than their 47 bytes each.
TEST(SurfelMap, HoldsASurfelIn48Bytes) {
  std::mt19937_64 rng(10);
  SurfelMap map;
  for (int i = 0; i < 400000; ++i) {
    Surfel s = RandomSurfel(&rng);
    s.position_in_world.z() = 0;
    map.Append(s);
  }
  const double bytes = 1. * map.id_end() / SurfelBlock::kCapacity * sizeof(SurfelBlock) +
                       1. * map.cell_count() * sizeof(SurfelCell);
  EXPECT_LE(bytes / static_cast<double>(map.size()), 48);
}

TEST(SurfelMap, EveryByteOfColorSurvives) {
  SurfelMap map;
  for (int byte = 0; byte < 256; ++byte) {
    Surfel s;
    s.color = {static_cast<std::uint8_t>(byte), static_cast<std::uint8_t>(255 - byte), 7};
    EXPECT_EQ(map.Color(map.Append(s)), s.color);
  }
}

TEST(Merge, IsTheWeightedAverage) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    SurfelMap map;
    map.Append(RandomSurfel(&rng));
    const Surfel q = map[0];
    const SurfelObservation p = RandomObservation(&rng);
    map.Merge(0, p, kNoCap);
    const double w = q.confidence, a = p.weight;
    const Eigen::Vector3d position =
        (w * q.position_in_world.cast<double>() + a * p.position_in_world.cast<double>()) / (w + a);
    const Eigen::Vector3d normal =
        (w * q.normal_in_world.cast<double>() + a * p.normal_in_world.cast<double>()).normalized();
    const Eigen::Vector3d color =
        (w * ColorAsVector(q.color) + a * p.color.cast<double>()) / (w + a);
    // A difference of up to 6, its product with the share (itself rounded twice) and a sum: not
    // more than five roundings of 6 on each axis.
    EXPECT_THAT(map[0].position_in_world.cast<double>(), VectorNear(position, 30 * kUlp * 2));
    EXPECT_THAT(map[0].normal_in_world.cast<double>(), VectorNear(normal, 10 * kUlp * 2));
    EXPECT_NEAR(map[0].normal_in_world.norm(), 1, 4 * kUlp);
    // Rounded to the next of 256 parts of a byte's step, on each of three channels.
    EXPECT_THAT(StoredColor(map, 0), VectorNear(color, std::sqrt(3) * 0.501 / 256));
    EXPECT_EQ(map[0].radius_m, std::min(q.radius_m, p.radius_m));
    EXPECT_NEAR(map[0].confidence, w + a, (w + a) * kUlp);
    EXPECT_EQ(map[0].first_seen, q.first_seen);
    EXPECT_EQ(map[0].last_seen, q.last_seen);
  }
}

TEST(Merge, WithoutShapeWeightKeepsTheShapeAndTakesColorAndWeight) {
  std::mt19937_64 rng(3);
  SurfelMap map;
  map.Append(RandomSurfel(&rng));
  const Surfel q = map[0];
  SurfelObservation p = RandomObservation(&rng);
  p.shape_weight = 0;
  map.Merge(0, p, kNoCap);
  EXPECT_EQ(map[0].position_in_world, q.position_in_world);
  EXPECT_EQ(map[0].normal_in_world, q.normal_in_world);
  EXPECT_EQ(map[0].radius_m, q.radius_m);
  EXPECT_FLOAT_EQ(map[0].confidence, q.confidence + p.weight);
  const double share = p.weight / (1. * q.confidence + p.weight);
  const Eigen::Vector3d color =
      ColorAsVector(q.color) + share * (p.color.cast<double>() - ColorAsVector(q.color));
  EXPECT_THAT(StoredColor(map, 0), VectorNear(color, std::sqrt(3) * 0.501 / 256));
}

TEST(Merge, OneObservationWithinASurfaceIsEnough) {
  std::mt19937_64 rng(6);
  for (const bool at_edge : {false, true}) {
    SurfelMap map;
    Surfel surfel = RandomSurfel(&rng);
    surfel.at_edge = at_edge;
    map.Append(surfel);
    SurfelObservation seen = RandomObservation(&rng);
    seen.at_edge = true;
    map.Merge(0, seen, kNoCap);
    EXPECT_EQ(map[0].at_edge, at_edge);
    seen.at_edge = false;
    map.Merge(0, seen, kNoCap);
    EXPECT_FALSE(map[0].at_edge);
  }
}

TEST(Merge, TouchesNoOtherSurfel) {
  std::mt19937_64 rng(4);
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.01f;  // in one cell
    map.Append(surfel);
  }
  const Surfel first = map[0], last = map[2];
  map.Merge(1, RandomObservation(&rng), kNoCap);
  EXPECT_EQ(AsTuple(map[0]), AsTuple(first));
  EXPECT_EQ(AsTuple(map[2]), AsTuple(last));
  ExpectConsistent(map);
}

TEST(Merge, ConfidenceStopsAtTheCapAndTheMapStillMoves) {
  SurfelMap map;
  Surfel s;
  s.normal_in_world = {0, 0, -1};
  s.confidence = 199.5f;
  s.radius_m = 0.01f;
  map.Append(s);
  SurfelObservation seen;
  seen.position_in_world = {0, 0, 1};
  seen.normal_in_world = {0, 0, -1};
  seen.radius_m = 0.01f;
  map.Merge(0, seen, 200);
  EXPECT_EQ(map[0].confidence, 200);
  EXPECT_FLOAT_EQ(map[0].position_in_world.z(), 1 / 200.5f);
  map.Merge(0, seen, 200);
  EXPECT_EQ(map[0].confidence, 200);
  EXPECT_FLOAT_EQ(map[0].position_in_world.z(), 1 / 200.5f + (1 - 1 / 200.5f) / 201);
}

// With w = 1 for the first and a = 1 for each further observation, the average is the mean.
TEST(Merge, EqualWeightsGiveTheArithmeticMean) {
  constexpr int kCount = 150;
  std::mt19937_64 rng(5);
  SurfelMap map;
  Surfel first = RandomSurfel(&rng);
  first.confidence = 1;
  map.Append(first);
  Eigen::Vector3d position_sum = first.position_in_world.cast<double>();
  Eigen::Vector3d color_sum = ColorAsVector(first.color);
  float smallest = first.radius_m;
  for (int n = 2; n <= kCount; ++n) {
    SurfelObservation seen = RandomObservation(&rng);
    seen.weight = seen.shape_weight = seen.color_weight = 1;
    position_sum += seen.position_in_world.cast<double>();
    color_sum += seen.color.cast<double>();
    smallest = std::min(smallest, seen.radius_m);
    map.Merge(0, seen, kNoCap);
  }
  EXPECT_EQ(map[0].confidence, kCount);
  EXPECT_EQ(map[0].radius_m, smallest);
  // Merge n rounds by e and damps older errors by (n - 1) / n, so that n E_n = (n - 1) E_(n-1) +
  // n e and E_N <= e (N + 1) / 2. For positions of up to 3 m, e is about 3 roundings of 3 m on each
  // axis; for colours 1/512 of a byte's step.
  constexpr double kGrowth = (kCount + 1) / 2.;
  EXPECT_THAT(map[0].position_in_world.cast<double>(),
              VectorNear(position_sum / kCount, std::sqrt(3) * 9 * kUlp * kGrowth));
  EXPECT_THAT(StoredColor(map, 0),
              VectorNear(color_sum / kCount, std::sqrt(3) * 0.51 / 256 * kGrowth));
}

// The stored colour moves as long as share * difference is at least half of 1/256: at the cap of
// 200 it comes within 201 / 512 of a byte's step, which rounds to the byte.
TEST(Merge, AColorAtTheCapStillComesToTheObservedByte) {
  for (const int goal : {0, 255}) {
    SurfelMap map;
    Surfel s;
    s.normal_in_world = {0, 0, -1};
    s.color = {static_cast<std::uint8_t>(255 - goal), 100, 128};
    s.confidence = 200;
    map.Append(s);
    SurfelObservation seen;
    seen.normal_in_world = {0, 0, -1};
    const Rgb8 color = {static_cast<std::uint8_t>(goal), 101, 127};
    seen.color = ColorAsVector(color).cast<float>();
    for (int i = 0; i < 3000; ++i) map.Merge(0, seen, 200);
    EXPECT_EQ(map.Color(0), color);
  }
}

// RemoveMarked() against sets: the kept surfels, each once.
void CheckRemoval(int size, float share, float spread, std::mt19937_64* rng) {
  SurfelMap map;
  std::vector<decltype(AsTuple(Surfel()))> expected, actual;
  for (int i = 0; i < size; ++i) {
    Surfel surfel = RandomSurfel(rng);
    surfel.position_in_world *= spread;
    const std::int32_t id = map.Append(surfel);
    const bool removed = Uniform(0, 1, rng) < share;
    if (removed) map.Mark(id);
    if (!removed) expected.push_back(AsTuple(surfel));
  }
  EXPECT_EQ(map.RemoveMarked(), size - expected.size());
  ExpectConsistent(map);
  ASSERT_EQ(map.size(), expected.size());
  for (const std::int32_t id : map.Ids()) actual.push_back(AsTuple(map[id]));
  std::sort(expected.begin(), expected.end());
  std::sort(actual.begin(), actual.end());
  EXPECT_EQ(actual, expected);
}

TEST(RemoveMarked, KeepsExactlyWhatItShould) {
  std::mt19937_64 rng(6);
  for (int trial = 0; trial < 300; ++trial) {
    const float spread = trial % 2 == 0 ? 0.01f : 0.2f;  // one cell, or a few
    CheckRemoval(static_cast<int>(rng() % 300), Uniform(0, 1, &rng), spread, &rng);
  }
  for (const int size : {0, 1, 63, 64, 65, 128, 129}) {
    CheckRemoval(size, 0, 0.01f, &rng);
    CheckRemoval(size, 1, 0.01f, &rng);
  }
}

TEST(RemoveMarked, KeepsColorsFinerThanBytes) {
  std::mt19937_64 rng(7);
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.01f;
    map.Append(surfel);
    map.Merge(i, RandomObservation(&rng), kNoCap);
  }
  const Eigen::Vector3d last = StoredColor(map, 2);
  map.Mark(0);
  map.RemoveMarked();
  EXPECT_EQ(StoredColor(map, 0), last);
}

// What is removed makes room for what comes.
TEST(RemoveMarked, MemoryIsUsedAgain) {
  std::mt19937_64 rng(8);
  SurfelMap map;
  std::int32_t id_end = 0;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 1000; ++i) {
      Surfel surfel = RandomSurfel(&rng);
      surfel.position_in_world *= 0.01f;
      map.Append(surfel);
    }
    if (round == 0) id_end = map.id_end();
    EXPECT_EQ(map.id_end(), id_end);
    for (const std::int32_t id : map.Ids()) map.Mark(id);
    EXPECT_EQ(map.RemoveMarked(), 1000u);
    EXPECT_FALSE(map.Has(0));
  }
}

}  // namespace
}  // namespace surfit
