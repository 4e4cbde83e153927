#include "cost_functions/row_sums.h"

#include <gmock/gmock.h>

#include <random>

namespace surfit::testing {
namespace {

template <typename V>
V RandomLanes(std::mt19937_64* random) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  V lanes;
  for (int k = 0; k < V::kCount; ++k) lanes.v[k] = uniform(*random);
  return lanes;
}

template <typename V>
class RowSumsTest : public ::testing::Test {};
using LaneTypes = ::testing::Types<Lanes<float>, Lanes<double>>;
TYPED_TEST_SUITE(RowSumsTest, LaneTypes);

TYPED_TEST(RowSumsTest, SumsOfLanesAreBitwiseEqualToSingleSums) {
  using V = TypeParam;
  constexpr int kSums = 11;
  std::mt19937_64 random(1);
  V lanes[kSums];
  double sums[kSums], expected[kSums];
  for (int k = 0; k < kSums; ++k) {
    lanes[k] = RandomLanes<V>(&random);
    sums[k] = 100. * k;
    expected[k] = sums[k] + SumOfLanes(lanes[k]);
  }
  AddSumsOfLanes<kSums>(lanes, sums);
  EXPECT_THAT(sums, ::testing::ElementsAreArray(expected));
}

TYPED_TEST(RowSumsTest, ProductsAreWeightedProductsOfColumns) {
  using V = TypeParam;
  std::mt19937_64 random(2);
  V rows[2][kRowColumns];
  for (auto& row : rows) {
    for (V& column : row) column = RandomLanes<V>(&random);
  }
  RowLanes<V> lanes;
  lanes.Add(rows, V(3.), RobustKernel{RobustKernelType::kNone, 1});
  RowSums sums;
  lanes.AddTo(&sums);
  for (int i = 0, k = 0; i < kRowColumns; ++i) {
    for (int j = i; j < kRowColumns; ++j, ++k) {
      double expected = 0;
      for (const auto& row : rows) expected += 3 * SumOfLanes(row[i] * row[j]);
      EXPECT_NEAR(sums.product[k], expected, 1e-5) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace surfit::testing
