#include "apps/live/map_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "live/sample_client.h"

namespace surfit {
namespace {

constexpr std::size_t kAll = 1 << 20;

Surfel RandomSurfel(std::mt19937_64* random) {
  std::uniform_real_distribution<float> place(-3, 3), share(0, 1);
  std::normal_distribution<float> normal;
  Surfel surfel;
  surfel.position_in_world = {place(*random), place(*random), place(*random)};
  surfel.normal_in_world =
      Eigen::Vector3f(normal(*random), normal(*random), normal(*random)).normalized();
  surfel.color = ToRgb8(255 * Eigen::Vector3f(share(*random), share(*random), share(*random)));
  surfel.radius_m = 0.001f + 0.02f * share(*random);
  surfel.confidence = 0.1f + 20 * share(*random);
  return surfel;
}

void Grow(int count, std::mt19937_64* random, SurfelMap* map) {
  for (int i = 0; i < count; ++i) map->Append(RandomSurfel(random));
}

// Moves 10 % of the surfels slightly, and removes 1 %.
void Change(std::mt19937_64* random, SurfelMap* map) {
  for (const std::int32_t id : map->Ids()) {
    const auto dice = (*random)() % 100;
    if (dice < 10) {
      SurfelObservation seen;
      const Surfel surfel = (*map)[id];
      seen.position_in_world = surfel.position_in_world + Eigen::Vector3f(0.01f, 0, 0);
      seen.normal_in_world = surfel.normal_in_world;
      seen.radius_m = surfel.radius_m;
      map->Merge(id, seen, 1000);
    } else if (dice == 10) {
      map->Mark(id);
    }
  }
  map->RemoveMarked();
}

void TakeRound(const MapSample& sample, std::size_t most, SampleClient* client) {
  while (client->Take(sample.ChangesFrom(client->place(), most))) {
  }
}

void LookAtAll(const SurfelMap& map, MapSample* sample) {
  while (!sample->Update(map, kAll)) {
  }
  sample->Update(map, kAll);
}

std::vector<PackedSurfel> AllOf(const MapSample& sample) {
  SampleClient fresh;
  TakeRound(sample, kAll, &fresh);
  return fresh.surfels();
}

// Sample by definition: slot s contains the surfel with id s 2^level.
std::vector<PackedSurfel> ByDefinition(const SurfelMap& map, std::uint32_t level) {
  std::vector<PackedSurfel> surfels;
  for (std::int64_t id = 0; id < map.id_end(); id += std::int64_t{1} << level) {
    const auto i = static_cast<std::int32_t>(id);
    surfels.push_back(map.Has(i) ? PackSurfel(map[i]) : PackedSurfel{});
  }
  return surfels;
}

TEST(MapSample, PacksASurfelToHalfAMillimetre) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Surfel surfel = RandomSurfel(&random);
    const PackedSurfel packed = PackSurfel(surfel);
    std::uint64_t place = 0;
    for (int k = 0; k < 8; ++k) place |= std::uint64_t{packed[k]} << (8 * k);
    for (int k = 0; k < 3; ++k) {
      const auto mm = static_cast<double>(place >> (21 * k) & 0x1fffff) - (1 << 20);
      EXPECT_NEAR(mm, 1000 * surfel.position_in_world[k], 0.501);
      EXPECT_NEAR(static_cast<std::int8_t>(packed[8 + k]), 127 * surfel.normal_in_world[k], 0.501);
    }
    EXPECT_EQ((Rgb8{packed[11], packed[12], packed[13]}), surfel.color);
    EXPECT_NEAR(packed[14], 2000 * surfel.radius_m, 0.501);
    EXPECT_EQ(packed[15], WeightByte::From(surfel.confidence));
  }
}

TEST(MapSample, ClampsDistantPositionsAndSmallRadii) {
  Surfel surfel;
  surfel.position_in_world = {1e9f, -1e9f, 0};
  surfel.radius_m = 1e-6f;
  const PackedSurfel packed = PackSurfel(surfel);
  std::uint64_t place = 0;
  for (int k = 0; k < 8; ++k) place |= std::uint64_t{packed[k]} << (8 * k);
  EXPECT_EQ(place & 0x1fffff, 0x1fffffu);
  EXPECT_EQ(place >> 21 & 0x1fffff, 0u);
  EXPECT_EQ(packed[14], 1);
}

TEST(MapSample, ContainsEveryNthSurfelWithinItsCapacity) {
  std::mt19937_64 random(2);
  SurfelMap map;
  MapSample sample(1000);
  for (int round = 0; round < 8; ++round) {
    Grow(2000, &random, &map);
    LookAtAll(map, &sample);
    const SampleChanges all = sample.ChangesFrom({}, kAll);
    EXPECT_LE(all.slots, 1000u);
    EXPECT_GT(all.slots, 400u);
    EXPECT_EQ(AllOf(sample), ByDefinition(map, all.level));
  }
}

// Clients request parts of different sizes at random times. The map grows, moves, loses surfels,
// and is subsampled during their rounds.
TEST(MapSample, ChangesBringEveryClientToTheSample) {
  std::mt19937_64 random(3);
  SurfelMap map;
  MapSample sample(3000);
  std::vector<SampleClient> clients(10);
  for (int step = 0; step < 400; ++step) {
    if (step < 300) Grow(40, &random, &map);
    if (step % 7 == 0) Change(&random, &map);
    sample.Update(map, 1 + random() % 1500);
    for (std::size_t i = 0; i < clients.size(); ++i) {
      if (random() % (i + 1) != 0) continue;  // later clients send fewer requests
      clients[i].Take(sample.ChangesFrom(clients[i].place(), 1 + random() % 700));
    }
  }
  LookAtAll(map, &sample);
  const std::vector<PackedSurfel> expected = AllOf(sample);
  EXPECT_EQ(expected, ByDefinition(map, sample.ChangesFrom({}, 1).level));
  for (SampleClient& client : clients) {
    TakeRound(sample, 500, &client);  // completes the current round
    TakeRound(sample, 500, &client);
    EXPECT_EQ(client.surfels(), expected);
  }
}

TEST(MapSample, SendsOnlyChanges) {
  std::mt19937_64 random(4);
  SurfelMap map;
  MapSample sample(kAll);
  Grow(5000, &random, &map);
  LookAtAll(map, &sample);
  SampleClient client;
  TakeRound(sample, kAll, &client);
  LookAtAll(map, &sample);
  EXPECT_TRUE(sample.ChangesFrom(client.place(), kAll).slot.empty());
  map.Append(RandomSurfel(&random));
  LookAtAll(map, &sample);
  EXPECT_EQ(sample.ChangesFrom(client.place(), kAll).slot.size(), 1u);
}

TEST(MapSample, RestartsForADifferentMap) {
  std::mt19937_64 random(5);
  SurfelMap large, small;
  Grow(5000, &random, &large);
  Grow(100, &random, &small);
  MapSample sample(1000);
  LookAtAll(large, &sample);
  SampleClient client;
  TakeRound(sample, 300, &client);
  sample.Reset(small);
  TakeRound(sample, 300, &client);
  EXPECT_EQ(client.surfels(), ByDefinition(small, client.place().level));
}

TEST(MapSample, CountsItsSurfels) {
  std::mt19937_64 random(6);
  SurfelMap map;
  MapSample sample(2000);
  for (int round = 0; round < 20; ++round) {
    Grow(300, &random, &map);
    Change(&random, &map);
    sample.Update(map, 777);
    const std::vector<PackedSurfel> all = AllOf(sample);
    EXPECT_EQ(sample.shown(), static_cast<std::size_t>(std::count_if(
                                  all.begin(), all.end(),
                                  [](const PackedSurfel& surfel) { return surfel[14] != 0; })));
  }
}

// Requests with arbitrary positions, including positions that were never sent.
TEST(MapSample, AnswersAnyPosition) {
  std::mt19937_64 random(7);
  SurfelMap map;
  Grow(5000, &random, &map);
  MapSample sample(1000);
  LookAtAll(map, &sample);
  for (int i = 0; i < 1000; ++i) {
    const auto number = [&] { return static_cast<std::uint32_t>(random() >> (random() % 64)); };
    const SampleChanges changes =
        sample.ChangesFrom({number() % 3, number(), number(), number()}, 10);
    EXPECT_LE(changes.slot.size(), 10u);
  }
}

}  // namespace
}  // namespace surfit
