#include "io/associate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace surfit {
namespace {

std::vector<std::pair<int, int>> Pairs(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<std::pair<int, int>> pairs;
  for (const auto [i, j] : AssociateByTime(a, b, 0.02)) pairs.emplace_back(i, j);
  return pairs;
}

using P = std::vector<std::pair<int, int>>;

TEST(AssociateByTime, PairsNearestNeighbours) {
  EXPECT_EQ(Pairs({1.0, 1.1, 1.2}, {1.01, 1.095, 1.205}), (P{{0, 0}, {1, 1}, {2, 2}}));
}

TEST(AssociateByTime, LeavesOutWhatHasNoPartnerInTime) {
  EXPECT_EQ(Pairs({1.0, 1.1, 1.2}, {1.021, 1.119, 1.3}), (P{{1, 1}}));
  EXPECT_EQ(Pairs({}, {1.0}), P{});
  EXPECT_EQ(Pairs({1.0}, {}), P{});
}

TEST(AssociateByTime, TheClosestPairComesFirstAndEachIsUsedOnce) {
  // 1.010 is nearer to 1.012 than 1.000 is, so 1.000 must go without.
  EXPECT_EQ(Pairs({1.000, 1.010}, {1.012}), (P{{1, 0}}));
  // Having lost 1.012 to 1.010, the first stamp takes the other one within 0.02 s.
  EXPECT_EQ(Pairs({1.000, 1.010}, {0.985, 1.012}), (P{{0, 0}, {1, 1}}));
}

TEST(AssociateByTime, IsStrictAboutTheLimit) {
  // Powers of two, so that the differences are exact.
  EXPECT_TRUE(AssociateByTime({1.0}, {1.25}, 0.25).empty());
  EXPECT_EQ(AssociateByTime({1.0}, {1.25}, 0.2500001).size(), 1u);
  EXPECT_EQ(AssociateByTime({1.25}, {1.0}, 0.2500001).size(), 1u);
}

// associate.py as its documentation says: of all pairs in time, again and again the closest one.
std::vector<std::pair<int, int>> BruteForce(const std::vector<double>& a,
                                            const std::vector<double>& b) {
  std::vector<bool> used_a(a.size()), used_b(b.size());
  std::vector<std::pair<int, int>> pairs;
  for (;;) {
    double best = 0.02;
    std::pair<int, int> pair;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < b.size(); ++j) {
        if (used_a[i] || used_b[j] || std::abs(a[i] - b[j]) >= best) continue;
        best = std::abs(a[i] - b[j]);
        pair = {static_cast<int>(i), static_cast<int>(j)};
      }
    }
    if (best == 0.02) break;
    used_a[pair.first] = used_b[pair.second] = true;
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(AssociateByTime, AgreesWithBruteForce) {
  std::mt19937_64 rng(11);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> a(40), b(35);
    for (auto* list : {&a, &b}) {
      for (double& stamp : *list) stamp = static_cast<double>(rng() % 100000) * 1e-5;
      std::sort(list->begin(), list->end());
    }
    EXPECT_EQ(Pairs(a, b), BruteForce(a, b));
  }
}

}  // namespace
}  // namespace surfit
