#include "surfit/core/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfit::testing {
namespace {

TEST(Lanes, AreEightFloatsOrFourDoubles) {
  EXPECT_EQ(Lanes<float>::kCount, 8);
  EXPECT_EQ(Lanes<double>::kCount, 4);
  const float x[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  const Lanes<float> y = Lanes<float>::Load(x) * 2. + 1.;
  for (int k = 0; k < 8; ++k) EXPECT_EQ(y[k], 2 * x[k] + 1);
}

TEST(Lanes, LoadUpToCount) {
  const double x[4] = {1, 2, 3, 4};
  const Lanes<double> loaded = Lanes<double>::LoadUpTo(x, 2);
  const double expected[4] = {1, 2, 2, 2};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(loaded[k], expected[k]);
    EXPECT_EQ(loaded.UpTo(3)[k], k < 3 ? expected[k] : 0);
    EXPECT_EQ(Lanes<double>::LoadUpTo(x, 9)[k], x[k]);
    EXPECT_EQ(loaded.UpTo(9)[k], expected[k]);
  }
}

TEST(Lanes, StoreUpToCount) {
  const float x[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  for (int count = 1; count <= 9; ++count) {
    float stored[9] = {};
    Lanes<float>::Load(x).StoreUpTo(stored, count);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(stored[k], k < count && k < 8 ? x[k] : 0) << count;
  }
}

TEST(Lanes, StoreIntegersRoundedTowardsZero) {
  const float x[8] = {0.9f, -0.9f, 1, -1, 2.5f, -2.5f, 8388607.5f, -100};
  const double y[4] = {1.9, -1.9, 0, 7};
  std::int32_t integers[8];
  Lanes<float>::Load(x).StoreTruncated(integers);
  for (int k = 0; k < 8; ++k) EXPECT_EQ(integers[k], static_cast<std::int32_t>(x[k]));
  Lanes<double>::Load(y).StoreTruncated(integers);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(integers[k], static_cast<std::int32_t>(y[k]));
}

TEST(Lanes, ComputeAbsMaxAndMin) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float xs[8] = {-1.5f, 2, -0.f, 0, -kInfinity, kInfinity, 1e-40f, -1e-40f};
  const auto x = Lanes<float>::Load(xs);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(abs(x)[k], std::abs(xs[k]));
    EXPECT_FALSE(std::signbit(abs(x)[k]));
    EXPECT_EQ(Max(x, 1.)[k], std::max(xs[k], 1.f));
    EXPECT_EQ(Max(1., x)[k], std::max(xs[k], 1.f));
    EXPECT_EQ(Min(x, 1.)[k], std::min(xs[k], 1.f));
    EXPECT_EQ(Min(1., x)[k], std::min(xs[k], 1.f));
  }
}

TEST(Lanes, SelectByCombinedConditions) {
  const double xs[4] = {1, 2, 3, 4};
  const auto x = Lanes<double>::Load(xs);
  const auto selected = Select((x > 1.) & (x < 4.), x, -1.);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(selected[k], k == 1 || k == 2 ? xs[k] : -1);
}

template <typename S>
void ExpectEveryOther() {
  using V = Lanes<S>;
  S values[2 * V::kCount];
  for (int k = 0; k < 2 * V::kCount; ++k) values[k] = static_cast<S>(k);
  const V a = V::Load(values), b = V::Load(values + V::kCount);
  for (int k = 0; k < V::kCount; ++k) {
    EXPECT_EQ(Evens(a, b)[k], 2 * k);
    EXPECT_EQ(Odds(a, b)[k], 2 * k + 1);
  }
}

TEST(Lanes, SplitIntoEvenAndOddElements) {
  ExpectEveryOther<float>();
  ExpectEveryOther<double>();
}

}  // namespace
}  // namespace surfit::testing
