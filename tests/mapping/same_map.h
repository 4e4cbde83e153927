#pragma once

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit::testing {

inline auto AsTuple(const Surfel& s) {
  const auto& p = s.position_in_world;
  const auto& n = s.normal_in_world;
  return std::make_tuple(p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), s.color.r, s.color.g, s.color.b,
                         s.radius_m, s.confidence, s.first_seen, s.last_seen, s.at_edge,
                         s.from_stereo);
}

// Checks the invariants of cells, blocks and bounds.
inline void ExpectConsistent(const SurfelMap& map) {
  std::size_t count = 0;
  for (std::int32_t c = 0; c < map.cell_count(); ++c) {
    const SurfelCell& cell = map.cell(c);
    EXPECT_FALSE(cell.is_marked);
    for (const std::int32_t b : cell.blocks) {
      const SurfelBlock& block = map.block(b);
      EXPECT_EQ(block.cell, c);
      EXPECT_EQ(block.to_remove, 0u);
      EXPECT_GT(block.count, 0);
      EXPECT_TRUE(b == cell.blocks.back() || block.count == SurfelBlock::kCapacity);
      count += block.count;
      for (const SurfelBounds& bounds : {block.bounds, cell.bounds}) {
        for (int k = 0; k < block.count; ++k) {
          EXPECT_GE(block.Confidence(k), bounds.least_confidence);
          EXPECT_GE(block.LastSeen(k), bounds.least_last_seen);
          const Eigen::Vector3f position = block.Position(k);
          for (int axis = 0; axis < 3; ++axis) {
            EXPECT_GE(position[axis], bounds.low[axis]);
            EXPECT_LE(position[axis], bounds.high[axis]);
          }
        }
      }
    }
  }
  EXPECT_EQ(count, map.size());
}

// Expects equal surfels in the same order.
inline void ExpectSameMap(const SurfelMap& a, const SurfelMap& b) {
  const std::vector<std::int32_t> ids = a.Ids();
  ASSERT_EQ(ids, b.Ids());
  std::size_t different = 0;
  for (const std::int32_t id : ids) {
    const SurfelBlock& p = a.block(id / SurfelBlock::kCapacity);
    const SurfelBlock& q = b.block(id / SurfelBlock::kCapacity);
    const int k = id % SurfelBlock::kCapacity;
    const auto same = [k](const auto& x, const auto& y) { return x[k] == y[k]; };
    different += !(p.Position(k) == q.Position(k) && same(p.nx, q.nx) && same(p.ny, q.ny) &&
                   same(p.nz, q.nz) && same(p.red, q.red) && same(p.green, q.green) &&
                   same(p.blue, q.blue) && same(p.radius, q.radius) &&
                   same(p.confidence, q.confidence) && p.FirstSeen(k) == q.FirstSeen(k) &&
                   p.LastSeen(k) == q.LastSeen(k) && p[k].at_edge == q[k].at_edge);
  }
  EXPECT_EQ(different, 0u) << "of " << ids.size() << " surfels";
}

}  // namespace surfit::testing
