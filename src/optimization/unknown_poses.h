#pragma once

#include <utility>
#include <vector>

#include "surfit/optimization/pose_graph.h"

namespace surfit {

inline constexpr int kHeld = -1;  // the number of a pose that is not moved

// The poses of a graph that linear systems are solved for.
struct UnknownPoses {
  std::vector<int> numbers;  // of each pose, or kHeld
  int count = 0;
  std::vector<std::pair<int, int>> pairs;  // numbers of b and a of each edge that joins two
};

inline UnknownPoses NumberUnknowns(const PoseGraph& graph, const std::vector<bool>& held) {
  UnknownPoses unknowns;
  for (const bool is_held : held) unknowns.numbers.push_back(is_held ? kHeld : unknowns.count++);
  for (const PoseGraphEdge& edge : graph.edges) {
    const int a = unknowns.numbers[edge.a], b = unknowns.numbers[edge.b];
    if (a != kHeld && b != kHeld) unknowns.pairs.emplace_back(b, a);
  }
  return unknowns;
}

}  // namespace surfit
