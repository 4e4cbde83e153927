#include "surfit/evaluation/error_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace surfit {
namespace {

TEST(Summarize, GivesTheFiguresOfAKnownSet) {
  // Sorted 1 2 3 6: the median's rank is 1.5, that of 90 % is 0.9 * 3 = 2.7.
  const ErrorStatistics s = Summarize({6, 1, 3, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt((36 + 1 + 9 + 4) / 4.));
  EXPECT_DOUBLE_EQ(s.mean, 3);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.p90, 3 + 0.7 * 3);
  EXPECT_DOUBLE_EQ(s.max, 6);
}

TEST(Summarize, OfOneErrorIsThatError) {
  const ErrorStatistics s = Summarize({0.25});
  for (const double value : {s.rmse, s.mean, s.median, s.p90, s.max}) EXPECT_EQ(value, 0.25);
}

}  // namespace
}  // namespace surfit
