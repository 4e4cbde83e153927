#include "mapping/map/eight_records.h"

#include <gtest/gtest.h>

namespace surfit::testing {
namespace {

float NumberAt(int k, int i) { return static_cast<float>(10 * k + i); }

TEST(EightRecords, LoadTransposesAndStoreReversesIt) {
  float given[8][8], back[8][8], by_number[8][8];
  const float* from[8];
  float* to[8];
  for (int k = 0; k < 8; ++k) {
    for (int i = 0; i < 8; ++i) given[k][i] = NumberAt(k, i);
    from[k] = given[k];
    to[k] = back[k];
  }
  WithInstructions([&](auto instructions) {
    using Records = EightRecords<decltype(instructions)>;
    typename Records::V columns[8];
    Records::Load(from, columns);
    for (int i = 0; i < 8; ++i) columns[i].Store(by_number[i]);
    Records::Store(columns, to);
  });
  for (int k = 0; k < 8; ++k) {
    for (int i = 0; i < 8; ++i) {
      EXPECT_EQ(by_number[i][k], NumberAt(k, i));
      EXPECT_EQ(back[k][i], NumberAt(k, i));
    }
  }
}

}  // namespace
}  // namespace surfit::testing
