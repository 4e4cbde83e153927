#include "surfit/mapping/surfel_map.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

TEST(SurfelMap, ReturnsAppendedSurfels) {
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

TEST(SurfelMap, StoresSurfelsByCell) {
  std::mt19937_64 rng(9);
  SurfelMap map;
  for (int i = 0; i < 5000; ++i) map.Append(RandomSurfel(&rng));
  EXPECT_LE(map.cell_count(), 13 * 13 * 13);  // a range of 6 m, plus half a cell at each end
  ExpectConsistent(map);
  for (std::int32_t c = 0; c < map.cell_count(); ++c) {
    const SurfelBounds& bounds = map.cell(c).bounds;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(bounds.high[axis] - bounds.low[axis], SurfelMap::kCellSize);
    }
  }
}

// A surfel of noise far outside the world needs only its cell.
TEST(SurfelMap, LimitsPositionsFarOutside) {
  SurfelMap map;
  Surfel s;
  for (const float x : {-1e30f, 1e30f, 1e6f}) {
    s.position_in_world = {x, 0, -x};
    const Eigen::Vector3f stored = map[map.Append(s)].position_in_world;
    const float farthest = std::copysign(SurfelMap::kFarthest_m, x);
    EXPECT_LT((stored - Eigen::Vector3f(farthest, 0, -farthest)).norm(), 1);
  }
  ExpectConsistent(map);
}

// All blocks of a cell except the last block are full. So a map with only 1000 surfels per cell
// needs little more than 30 bytes per surfel.
TEST(SurfelMap, NeedsAtMost31BytesPerSurfel) {
  std::mt19937_64 rng(10);
  SurfelMap map;
  for (int i = 0; i < 400000; ++i) {
    Surfel s = RandomSurfel(&rng);
    s.position_in_world.z() = 0;
    map.Append(s);
  }
  const double bytes = 1. * map.id_end() / SurfelBlock::kCapacity * sizeof(SurfelBlock) +
                       1. * map.cell_count() * sizeof(SurfelCell);
  EXPECT_LE(bytes / static_cast<double>(map.size()), 31);
}

TEST(SurfelMap, KeepsEveryByteOfColor) {
  SurfelMap map;
  for (int byte = 0; byte < 256; ++byte) {
    Surfel s;
    s.color = {static_cast<std::uint8_t>(byte), static_cast<std::uint8_t>(255 - byte), 7};
    EXPECT_EQ(map.Color(map.Append(s)), s.color);
  }
}

// Compares RemoveMarked() with sets: each kept surfel once.
void CheckRemoval(int size, float share, float spread, std::mt19937_64* rng) {
  SurfelMap map;
  std::vector<decltype(AsTuple(Surfel()))> expected, actual;
  for (int i = 0; i < size; ++i) {
    Surfel surfel = RandomSurfel(rng);
    for (float& x : surfel.position_in_world) x = StoredCoordinate(spread * x);
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

TEST(RemoveMarked, RemovesMarkedSurfelsOnly) {
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

TEST(Relocate, RemovesMarkedSurfels) {
  std::mt19937_64 rng(9);
  SurfelMap map;
  std::vector<std::int32_t> ids;
  for (int i = 0; i < 100; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.01f;
    surfel.first_seen = i;
    ids.push_back(map.Append(surfel));
  }
  std::vector<SurfelMove> moves;
  for (int i = 0; i < 100; i += 2) moves.push_back({ids[i], {5, 0, 0}});  // to another cell
  for (int i = 0; i < 100; i += 4) map.Mark(ids[i]);
  for (int i = 1; i < 100; i += 4) map.Mark(ids[i]);
  EXPECT_EQ(map.Relocate(moves), 25u);
  ExpectConsistent(map);
  EXPECT_EQ(map.size(), 50u);
  for (const std::int32_t id : map.Ids()) {
    const Surfel surfel = map[id];
    EXPECT_GE(surfel.first_seen % 4, 2);
    EXPECT_EQ(surfel.position_in_world.x() == 5, surfel.first_seen % 4 == 2);
  }
  EXPECT_EQ(map.RemoveMarked(), 0u);
}

TEST(SurfelMap, RejectsMarksOfUnusedIds) {
  SurfelMap map;
  std::mt19937_64 rng(10);
  map.Append(RandomSurfel(&rng));
  for (const std::int32_t id : {-1, 1, SurfelBlock::kCapacity})
    ExpectInputError([&] { map.Mark(id); }, Names(id));
}

TEST(RemoveMarked, KeepsFractionsOfColors) {
  std::mt19937_64 rng(7);
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.01f;
    map.Append(surfel);
    map.Merge(i, RandomObservation(map[i], &rng), kNoCap);
  }
  const Eigen::Vector3d last = StoredColor(map, 2);
  map.Mark(0);
  map.RemoveMarked();
  EXPECT_EQ(StoredColor(map, 0), last);
}

TEST(RemoveMarked, ReusesMemory) {
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
}  // namespace surfit::testing
