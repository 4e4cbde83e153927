#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr double kUlp = 6e-8;  // relative rounding of a float, 2^-24

TEST(Merge, IsWeightedAverage) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    SurfelMap map;
    map.Append(RandomSurfel(&rng));
    const Surfel q = map[0];
    const SurfelObservation p = RandomObservation(map[0], &rng);
    map.Merge(0, p, kNoCap);
    const double w = q.confidence, a = p.weight;
    const Eigen::Vector3d position =
        (w * q.position_in_world.cast<double>() + a * p.position_in_world.cast<double>()) / (w + a);
    const Eigen::Vector3d normal =
        (w * q.normal_in_world.cast<double>() + a * p.normal_in_world.cast<double>()).normalized();
    const double wc = q.color_weight, ac = p.color_weight;
    const Eigen::Vector3d color =
        (wc * ColorAsVector(q.color) + ac * p.color.cast<double>()) / (wc + ac);
    // A difference, its product with the weight (two roundings), and two sums of at most 4: at most
    // five roundings of 4 per axis.
    EXPECT_THAT(map[0].position_in_world.cast<double>(),
                VectorNear(position, 20 * kUlp * 2 + kPositionRounding));
    EXPECT_THAT(map[0].normal_in_world.cast<double>(),
                VectorNear(normal, 10 * kUlp * 2 + kNormalRounding));
    EXPECT_NEAR(map[0].normal_in_world.norm(), 1, 4 * kUlp + kNormalRounding);
    // Colours are stored in steps of 1/32 of a byte step, in three channels.
    EXPECT_THAT(StoredColor(map, 0), VectorNear(color, std::sqrt(3) * 0.501 / 32));
    EXPECT_LE(map[0].color_weight, (wc + ac) * (1 + kUlp));
    EXPECT_GE(map[0].color_weight, (wc + ac) * 8 / 9);
    EXPECT_EQ(map[0].radius_m, std::min(q.radius_m, p.radius_m));
    EXPECT_NEAR(map[0].confidence, w + a, (w + a) * kUlp + kConfidenceRounding);
    EXPECT_EQ(map[0].first_seen, q.first_seen);
    EXPECT_EQ(map[0].last_seen, q.last_seen);
  }
}

TEST(Merge, KeepsGeometryWithoutShapeWeight) {
  std::mt19937_64 rng(3);
  SurfelMap map;
  map.Append(RandomSurfel(&rng));
  const Surfel q = map[0];
  SurfelObservation p = RandomObservation(map[0], &rng);
  p.shape_weight = 0;
  map.Merge(0, p, kNoCap);
  EXPECT_EQ(map[0].position_in_world, q.position_in_world);
  EXPECT_EQ(map[0].normal_in_world, q.normal_in_world);
  EXPECT_EQ(map[0].radius_m, q.radius_m);
  EXPECT_NEAR(map[0].confidence, q.confidence + p.weight, 1.01 * kConfidenceRounding);
  const double share = p.color_weight / (1. * q.color_weight + p.color_weight);
  const Eigen::Vector3d color =
      ColorAsVector(q.color) + share * (p.color.cast<double>() - ColorAsVector(q.color));
  EXPECT_THAT(StoredColor(map, 0), VectorNear(color, std::sqrt(3) * 0.501 / 32));
}

TEST(Merge, OneObservationInsideSurfaceClearsEdgeFlag) {
  std::mt19937_64 rng(6);
  for (const bool at_edge : {false, true}) {
    SurfelMap map;
    Surfel surfel = RandomSurfel(&rng);
    surfel.at_edge = at_edge;
    map.Append(surfel);
    SurfelObservation seen = RandomObservation(map[0], &rng);
    seen.at_edge = true;
    map.Merge(0, seen, kNoCap);
    EXPECT_EQ(map[0].at_edge, at_edge);
    seen.at_edge = false;
    map.Merge(0, seen, kNoCap);
    EXPECT_FALSE(map[0].at_edge);
  }
}

TEST(Merge, KeepsOtherSurfels) {
  std::mt19937_64 rng(4);
  SurfelMap map;
  for (int i = 0; i < 3; ++i) {
    Surfel surfel = RandomSurfel(&rng);
    surfel.position_in_world *= 0.01f;  // all in one cell
    map.Append(surfel);
  }
  const Surfel first = map[0], last = map[2];
  map.Merge(1, RandomObservation(map[1], &rng), kNoCap);
  EXPECT_EQ(AsTuple(map[0]), AsTuple(first));
  EXPECT_EQ(AsTuple(map[2]), AsTuple(last));
  ExpectConsistent(map);
}

TEST(Merge, LimitsConfidenceAndStillMovesSurfel) {
  SurfelMap map;
  Surfel s;
  s.normal_in_world = {0, 0, -1};
  s.confidence = 199.5f;
  s.radius_m = 0.01f;
  map.Append(s);
  SurfelObservation seen;
  seen.position_in_world = {0, 0, 0.2f};
  seen.normal_in_world = {0, 0, -1};
  seen.radius_m = 0.01f;
  map.Merge(0, seen, 200);
  EXPECT_EQ(map[0].confidence, 200);
  EXPECT_NEAR(map[0].position_in_world.z(), 0.2 / 200.5, kPositionRounding);
  map.Merge(0, seen, 200);
  EXPECT_EQ(map[0].confidence, 200);
  EXPECT_NEAR(map[0].position_in_world.z(), 0.2 / 200.5 + (0.2 - 0.2 / 200.5) / 201,
              2 * kPositionRounding);
}

// With w = 1 for the first and a = 1 for each further observation, the weighted average is the
// mean.
TEST(Merge, EqualWeightsGiveMean) {
  constexpr int kCount = 150;
  std::mt19937_64 rng(5);
  SurfelMap map;
  Surfel first = RandomSurfel(&rng);
  first.confidence = first.color_weight = 1;
  map.Append(first);
  Eigen::Vector3d position_sum = first.position_in_world.cast<double>();
  float smallest = first.radius_m;
  for (int n = 2; n <= kCount; ++n) {
    SurfelObservation seen = RandomObservation(first, &rng);
    seen.weight = seen.shape_weight = seen.color_weight = 1;
    position_sum += seen.position_in_world.cast<double>();
    smallest = std::min(smallest, seen.radius_m);
    map.Merge(0, seen, kNoCap);
  }
  EXPECT_EQ(map[0].confidence, kCount);
  EXPECT_EQ(map[0].radius_m, smallest);
  // Merge n has the rounding error e and scales older errors by (n - 1) / n: n E_n = (n - 1)
  // E_(n-1) + n e, so E_N <= e (N + 1) / 2. For positions up to 3 m, e is about 3 roundings of 3 m
  // per axis, and the rounding of the stored position.
  constexpr double kGrowth = (kCount + 1) / 2.;
  EXPECT_THAT(
      map[0].position_in_world.cast<double>(),
      VectorNear(position_sum / kCount, (std::sqrt(3) * 9 * kUlp + kPositionRounding) * kGrowth));
}

// Sums of weights up to 8 are exact in a byte, so the first eight colours are averaged.
TEST(Merge, FirstColorsOfEqualWeightGiveMean) {
  std::mt19937_64 rng(6);
  SurfelMap map;
  Surfel first = RandomSurfel(&rng);
  first.color_weight = 1;
  map.Append(first);
  Eigen::Vector3d sum = ColorAsVector(first.color);
  for (int n = 2; n <= 8; ++n) {
    SurfelObservation seen = RandomObservation(map[0], &rng);
    seen.color_weight = 1;
    sum += seen.color.cast<double>();
    map.Merge(0, seen, kNoCap);
    EXPECT_EQ(map[0].color_weight, n);
    EXPECT_THAT(StoredColor(map, 0), VectorNear(sum / n, std::sqrt(3) * 0.51 / 32 * n));
  }
}

// The sum of weights of 1 is limited to 16, so each further colour has the weight 1/17.
TEST(Merge, ColorsChangeAfterManyObservations) {
  SurfelMap map;
  Surfel s = Disc({0, 0, 1}, {0, 0, -1}, 0.01f, 1);
  s.color = {0, 100, 0};
  map.Append(s);
  SurfelObservation seen;
  seen.normal_in_world = {0, 0, -1};
  seen.color = {0, 100, 0};
  for (int i = 0; i < 1000; ++i) map.Merge(0, seen, kNoCap);
  EXPECT_EQ(map[0].color_weight, 16);
  seen.color = {200, 100, 0};
  for (int i = 0; i < 48; ++i) map.Merge(0, seen, kNoCap);
  EXPECT_NEAR(map.Color(0).r, 200 * (1 - std::pow(16. / 17, 48)), 1);
}

// Coarse colours of weight 1/100 hardly change a colour of weight 1, and a colour of weight 1
// replaces them.
TEST(Merge, SharpColorsHaveLargestWeight) {
  for (const bool sharp_first : {true, false}) {
    SurfelMap map;
    Surfel s = Disc({0, 0, 1}, {0, 0, -1}, 0.01f, 1);
    s.color = sharp_first ? Rgb8{200, 0, 0} : Rgb8{0, 0, 0};
    s.color_weight = sharp_first ? 1 : 0.01f;
    map.Append(s);
    SurfelObservation seen;
    seen.normal_in_world = {0, 0, -1};
    seen.color_weight = sharp_first ? 0.01f : 1;
    seen.color = {sharp_first ? 0.f : 200.f, 0, 0};
    map.Merge(0, seen, kNoCap);
    EXPECT_NEAR(map.Color(0).r, 198, 1);
  }
}

TEST(WeightByte, HasRelativeErrorBelowOneEighth) {
  EXPECT_EQ(WeightByte::ToFloat(WeightByte::From(0)), 0);
  float before = 0;
  for (float weight = 1.1e-6f; weight < 2000; weight *= 1.013f) {
    const float stored = WeightByte::ToFloat(WeightByte::From(weight));
    EXPECT_LE(stored, weight);
    EXPECT_GE(stored, weight * 8 / 9);
    EXPECT_GE(stored, before);
    before = stored;
  }
  for (const float weight : {1.f, 1.5f, 2.f, 7.f, 0.25f}) {
    EXPECT_EQ(WeightByte::ToFloat(WeightByte::From(weight)), weight);
  }
  EXPECT_GT(WeightByte::ToFloat(WeightByte::From(1e-30f)), 0);
  EXPECT_GT(WeightByte::ToFloat(WeightByte::From(1e30f)), 2000);
}

TEST(SmallLength, HasRelativeErrorBelow1In2048) {
  EXPECT_EQ(SmallLength::ToFloat(SmallLength::From(0)), 0);
  for (float length_m = 1.1e-6f; length_m < 4000; length_m *= 1.00013f) {
    const float stored = SmallLength::ToFloat(SmallLength::From(length_m));
    ASSERT_LE(stored, length_m);
    ASSERT_GE(stored, length_m * (1 - 1.f / 2048));
  }
  for (int small = 0; small < 65536; ++small) {
    const auto bits = static_cast<std::uint16_t>(small);
    ASSERT_EQ(SmallLength::From(SmallLength::ToFloat(bits)), bits);
  }
}

TEST(SmallNumber, RoundsToNearestAndClamps) {
  for (int i = 0; i < 20000; ++i) {
    const float number = 0.0127f * static_cast<float>(i), fraction = number / 256;
    ASSERT_NEAR(SmallSum::ToFloat(SmallSum::From(number)), number, kConfidenceRounding);
    ASSERT_NEAR(SmallCoordinate::ToFloat(SmallCoordinate::From(fraction)), fraction,
                0.5 * SmallCoordinate::kStep);
  }
  for (int small = 0; small < 65536; ++small) {
    const auto bits = static_cast<std::uint16_t>(small);
    ASSERT_EQ(SmallSum::From(SmallSum::ToFloat(bits)), bits);
    ASSERT_EQ(SmallCoordinate::From(SmallCoordinate::ToFloat(bits)), bits);
  }
  EXPECT_EQ(SmallSum::From(-1), 0);
  EXPECT_EQ(SmallSum::From(1e30f), 65535);
}

// A cell has half its size as a margin for merged surfels.
TEST(Merge, KeepsSurfelsWithinTheMarginOfTheirCell) {
  SurfelMap map;
  map.Append(Disc({0.2f, 0, 1}, {0, 0, -1}, 0.01f, 1));
  SurfelObservation seen;
  seen.normal_in_world = {0, 0, -1};
  for (const float x : {0.7f, 3.f}) {
    seen.position_in_world = {x, 0, 1};
    map.Merge(0, seen, kNoCap);
    EXPECT_NEAR(map[0].position_in_world.x(), x == 3 ? 0.5 : 0.45, 2 * kPositionRounding);
    ExpectConsistent(map);
  }
}

TEST(SurfelBlock, StoresEveryFrameIndex) {
  SurfelBlock block;
  for (const std::int32_t frame : {0, 1, 65535, 65536, SurfelBlock::kMaxFrame}) {
    block.SetFirstSeen(3, frame);
    block.SetLastSeen(5, frame);
    EXPECT_EQ(block.FirstSeen(3), frame);
    EXPECT_EQ(block.LastSeen(5), frame);
  }
}

TEST(SmallUnit, RoundsToNearest) {
  for (const float exact : {-1.f, 0.f, 1.f}) {
    EXPECT_EQ(SmallUnit::ToFloat(SmallUnit::From(exact)), exact);
  }
  for (float number = -1; number <= 1; number += 1.3e-5f) {
    ASSERT_NEAR(SmallUnit::ToFloat(SmallUnit::From(number)), number, 0.505 / 32767);
  }
  for (int small = -32767; small <= 32767; ++small) {
    const auto bits = static_cast<std::int16_t>(small);
    ASSERT_EQ(SmallUnit::From(SmallUnit::ToFloat(bits)), bits);
  }
  EXPECT_EQ(SmallUnit::ToFloat(SmallUnit::From(1.0001f)), 1);
  EXPECT_EQ(SmallUnit::ToFloat(SmallUnit::From(-7)), -1);
}

// The stored normal changes if share * difference is at least half of 1 / 32767. The share is 1 /
// 201.
TEST(Merge, NormalsConvergeToObservations) {
  SurfelMap map;
  map.Append(Disc({0, 0, 1}, {0, 0, -1}, 0.01f, 200));
  SurfelObservation seen;
  seen.position_in_world = {0, 0, 1};
  seen.normal_in_world = Eigen::Vector3f(0.3f, -0.1f, -1).normalized();
  seen.radius_m = 0.01f;
  for (int i = 0; i < 5000; ++i) map.Merge(0, seen, 200);
  EXPECT_THAT(map[0].normal_in_world, VectorNear(seen.normal_in_world, 201 * kNormalRounding));
}

// The stored colour changes if share * difference is at least half of 1/32. With a share of at
// least 1/17, the error is below 17/64 of a byte step, which rounds to the byte.
TEST(Merge, ColorsConvergeToObservedByte) {
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

}  // namespace
}  // namespace surfit::testing
