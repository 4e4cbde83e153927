#include "evaluation/morton_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "testing/random_pose.h"

namespace surfit {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// The Z-curve visits the corners of a cube with x in the lowest bit, y in the next, z in the last.
TEST(MortonOrder, VisitsTheCornersOfACube) {
  const std::vector<Eigen::Vector3f> corners = {{1, 1, 1}, {0, 1, 1}, {1, 0, 1}, {0, 0, 1},
                                                {1, 1, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}};
  EXPECT_THAT(MortonOrder(corners), ElementsAre(7, 6, 5, 4, 3, 2, 1, 0));
}

TEST(MortonOrder, KeepsNeighboursTogether) {
  std::mt19937_64 rng(1);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 4096; ++i) points.push_back(testing::RandomVector(1, &rng).cast<float>());
  const auto order = MortonOrder(points);
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i);
  double steps = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    steps += (points[order[i]] - points[order[i - 1]]).norm();
  }
  // At random the mean step in a cube of side 2 is 1.32. 16^3 points are 2/16 apart; the curve
  // jumps now and then, by no more than a few times that on average.
  EXPECT_LT(steps / 4095, 3 * 2. / 16);
}

TEST(MortonOrder, TakesDegenerateClouds) {
  EXPECT_THAT(MortonOrder({}), IsEmpty());
  EXPECT_THAT(MortonOrder({{5, 6, 7}, {5, 6, 7}}), ElementsAre(0, 1));
  EXPECT_THAT(MortonOrder({{3e38f, 0, 0}, {-3e38f, 0, 0}}), ElementsAre(1, 0));
}

}  // namespace
}  // namespace surfit
