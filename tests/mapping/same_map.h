#pragma once

#include <gtest/gtest.h>

#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

// Expects that all arrays have the same length.
inline void ExpectDense(const SurfelMap& map) {
  const std::size_t n = map.size();
  for (const auto* array :
       {&map.x, &map.y, &map.z, &map.nx, &map.ny, &map.nz, &map.radius_m, &map.confidence}) {
    EXPECT_EQ(array->size(), n);
  }
  for (const auto* array : {&map.red, &map.green, &map.blue}) EXPECT_EQ(array->size(), n);
  EXPECT_EQ(map.at_edge.size(), n);
  for (const auto* array : {&map.first_seen, &map.last_seen}) EXPECT_EQ(array->size(), n);
}

// Expects all arrays of two maps to be the same, value for value. No message of a whole array.
inline void ExpectSameMap(const SurfelMap& a, const SurfelMap& b) {
  EXPECT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << "positions differ";
  EXPECT_TRUE(a.nx == b.nx && a.ny == b.ny && a.nz == b.nz) << "normals differ";
  EXPECT_TRUE(a.red == b.red && a.green == b.green && a.blue == b.blue) << "colours differ";
  EXPECT_TRUE(a.radius_m == b.radius_m) << "radii differ";
  EXPECT_TRUE(a.confidence == b.confidence) << "confidences differ";
  EXPECT_TRUE(a.first_seen == b.first_seen && a.last_seen == b.last_seen) << "times differ";
  EXPECT_TRUE(a.at_edge == b.at_edge) << "edges differ";
}

}  // namespace surfit::testing
