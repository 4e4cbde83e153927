#include "geometry/kd_tree.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "testing/matchers.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr float kAnywhere = KdTree::kAnyDistance;

Points RandomPoints(int count, double size, int seed) {
  std::mt19937_64 rng(seed);
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(RandomVector(size, &rng).cast<float>());
  return points;
}

// Many points at few grid positions: all distances tie.
Points GridPoints(int count, int seed) {
  Points points = RandomPoints(count, 3, seed);
  for (auto& point : points) point = point.array().round();
  return points;
}

// Index of the nearest point, in the arithmetic of the tree. Returns the first of several nearest
// points. -1: no point within the bound.
int BruteForceNearest(const Points& points, const Eigen::Vector3f& q, float bound) {
  int nearest = -1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f d = q - points[i];
    const float distance = d.x() * d.x() + d.y() * d.y() + d.z() * d.z();
    if (distance > bound || (nearest >= 0 && distance == bound)) continue;
    nearest = static_cast<int>(i);
    bound = distance;
  }
  return nearest;
}

int PositionOf(const KdTree& tree, std::uint32_t rank) {
  return rank == KdTree::kNone ? -1 : static_cast<int>(tree.order()[rank]);
}

class KdTreeOfSize : public ::testing::TestWithParam<int> {};

// Sizes from one leaf, over each number of children of the root, to several levels.
INSTANTIATE_TEST_SUITE_P(Sizes, KdTreeOfSize,
                         ::testing::Values(1, 2, 31, 33, 65, 200, 257, 300, 1000, 5000));

TEST_P(KdTreeOfSize, NearestAgreesWithBruteForce) {
  for (const Points& points : {RandomPoints(GetParam(), 1, 1), GridPoints(GetParam(), 1)}) {
    const KdTree tree(points);
    Points queries = RandomPoints(150, 1.5, 2);
    for (const auto& query : GridPoints(150, 3)) queries.push_back(query);
    std::mt19937_64 rng(4);
    for (const auto& query : queries) {
      for (const float bound : {kAnywhere, 1.f, 0.01f}) {
        const int expected = BruteForceNearest(points, query, bound);
        const KdTree::Neighbor found = tree.Nearest(query, bound);
        ASSERT_EQ(PositionOf(tree, found.rank), expected);
        if (expected < 0) continue;
        ASSERT_EQ(found.squared_distance, tree.SquaredDistance(query, found.rank));
        ASSERT_EQ(tree.Point(found.rank), points[expected]);
        const auto hint = static_cast<std::uint32_t>(rng() % points.size());
        ASSERT_EQ(tree.Nearest(query, bound, hint).rank, found.rank);
      }
    }
  }
}

TEST_P(KdTreeOfSize, FindWithinAgreesWithBruteForce) {
  for (const Points& points : {RandomPoints(GetParam(), 1, 1), GridPoints(GetParam(), 1)}) {
    const KdTree tree(points);
    std::vector<std::uint32_t> found = {7};
    for (const auto& query : RandomPoints(50, 1.5, 2)) {
      for (const float bound : {0.f, 0.05f, 1.f, kAnywhere}) {
        std::vector<std::uint32_t> expected;
        for (std::uint32_t rank = 0; rank < tree.size(); ++rank) {
          if (tree.SquaredDistance(query, rank) <= bound) expected.push_back(rank);
        }
        tree.FindWithin(query, bound, &found);
        ASSERT_EQ(found, expected);
      }
    }
  }
}

TEST_P(KdTreeOfSize, FindNearestAgreesWithBruteForce) {
  for (const Points& points : {RandomPoints(GetParam(), 1, 3), GridPoints(GetParam(), 4)}) {
    const KdTree tree(points);
    std::vector<KdTree::Neighbor> found;
    for (const Eigen::Vector3f& query : RandomPoints(20, 1, 5)) {
      std::vector<float> distances;
      for (std::uint32_t rank = 0; rank < tree.size(); ++rank) {
        distances.push_back(tree.SquaredDistance(query, rank));
      }
      std::sort(distances.begin(), distances.end());
      tree.FindNearest(query, 7, &found);
      ASSERT_EQ(found.size(), std::min<std::size_t>(7, points.size()));
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].squared_distance, distances[i]);
        EXPECT_EQ(found[i].squared_distance, tree.SquaredDistance(query, found[i].rank));
      }
    }
  }
}

TEST(KdTree, DistancesAreInclusive) {
  const KdTree tree({{0.25f, 0, 0}});
  std::vector<std::uint32_t> found;
  EXPECT_EQ(tree.Nearest({0, 0, 0}, 0.0625f).rank, 0u);
  EXPECT_EQ(tree.Nearest({0, 0, 0}, 0.0624f).rank, KdTree::kNone);
  tree.FindWithin({0, 0, 0}, 0.0625f, &found);
  EXPECT_THAT(found, ElementsAre(0));
  tree.FindWithin({0, 0, 0}, 0.0624f, &found);
  EXPECT_THAT(found, IsEmpty());
}

TEST(KdTree, OrderIsPermutationThatGroupsNeighbours) {
  const Points points = RandomPoints(4096, 1, 1);
  const KdTree tree(points);
  auto sorted = tree.order();
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  double steps = 0;
  for (std::uint32_t rank = 1; rank < tree.size(); ++rank) {
    steps += (tree.Point(rank) - tree.Point(rank - 1)).norm();
  }
  // The mean step in random order is 1.32 in a cube of side 2. A leaf of 32 of 4096 points has the
  // side 2 / 128^(1/3) = 0.4, and few steps leave a leaf.
  EXPECT_LT(steps / 4095, 0.4);
}

TEST(KdTree, SupportsDegenerateClouds) {
  std::vector<std::uint32_t> found = {7};
  const KdTree none({});
  EXPECT_EQ(none.Nearest({0, 0, 0}).rank, KdTree::kNone);
  none.FindWithin({0, 0, 0}, kAnywhere, &found);
  EXPECT_THAT(found, IsEmpty());

  const KdTree same(Points(1000, Eigen::Vector3f(5, 6, 7)));
  EXPECT_EQ(PositionOf(same, same.Nearest({5, 6, 7}, 0.f).rank), 0);
  same.FindWithin({5, 6, 7}, 0.f, &found);
  EXPECT_EQ(found.size(), 1000u);

  // The squared distances overflow: all points are equally far.
  const KdTree far(Points(100, Eigen::Vector3f(3e38f, 0, 0)));
  EXPECT_EQ(PositionOf(far, far.Nearest({-3e38f, 0, 0}).rank), 0);
}

TEST(KdTree, IsTheSameAtAnyNumberOfThreads) {
  const Points points = RandomPoints(30000, 1, 1);
  const auto orders = AtThreads({1, 4}, [&] { return KdTree(points).order(); });
  EXPECT_EQ(orders[0], orders[1]);
}

}  // namespace
}  // namespace surfit::testing
