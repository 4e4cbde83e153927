#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace surfit {

// Balanced k-d tree (Friedman, Bentley and Finkel 1977) over points in single precision. A node
// stores the tight boxes of eight children, which is three binary splits.
//
// Results are exact in the arithmetic of SquaredDistance() and do not depend on hints. Rounding is
// monotonic, so the distance to a box never exceeds the distance to a point in it.
//
// The tree stores a copy of the points in spatial order. The rank of a point is its position in
// this order. Queries are thread-safe. An empty tree is valid and finds nothing.
class KdTree {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr float kAnyDistance = std::numeric_limits<float>::infinity();

  struct Neighbor {
    std::uint32_t rank = kNone;
    float squared_distance = kAnyDistance;
  };

  // Requires finite points, which is not checked. Aborts for 2^31 points or more. Built in
  // parallel. The result does not depend on the number of threads.
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);

  std::size_t size() const { return order_.size(); }
  // Index of the input point, by rank.
  const std::vector<std::uint32_t>& order() const { return order_; }
  Eigen::Vector3f Point(std::uint32_t rank) const { return {x_[rank], y_[rank], z_[rank]}; }

  // dx^2 + dy^2 + dz^2, summed from left to right, with single-precision rounding of each
  // operation.
  float SquaredDistance(const Eigen::Vector3f& query, std::uint32_t rank) const {
    const float dx = query.x() - x_[rank], dy = query.y() - y_[rank], dz = query.z() - z_[rank];
    return dx * dx + dy * dy + dz * dz;
  }

  // Nearest point up to and including the maximum distance; rank kNone: no point, also for a NaN
  // query. For equal distances, the first input point. `hint`: rank of a point that is probably
  // near, or kNone.
  Neighbor Nearest(const Eigen::Vector3f& query, float max_squared_distance = kAnyDistance,
                   std::uint32_t hint = kNone) const;

  // Replaces `neighbors` by the `count` nearest points, or by all points if there are fewer. They
  // are sorted by distance. The choice among equal distances is unspecified. The time does not grow
  // with the number of equal points.
  void FindNearest(const Eigen::Vector3f& query, std::size_t count,
                   std::vector<Neighbor>* neighbors) const;

  // Replaces `ranks` by the ranks of all points up to and including the maximum distance, in
  // ascending order.
  void FindWithin(const Eigen::Vector3f& query, float max_squared_distance,
                  std::vector<std::uint32_t>* ranks) const;

 private:
  static constexpr int kWidth = 4;     // lanes
  static constexpr int kChildren = 8;  // per node

  struct Box;
  // Bounds of the boxes of the children by axis. Missing children of the root have NaN bounds, so
  // no search visits them.
  struct Node {
    Node();
    float low[3][kChildren], high[3][kChildren];
  };
  class Sorter;
  class Search;
  class NearestSearch;
  class FewNearestSearch;
  class RangeSearch;

  void MakeNodes();
  std::uint32_t LeafBegin(std::uint64_t leaf) const {
    return static_cast<std::uint32_t>(leaf * order_.size() >> depth_);
  }

  int depth_ = 0;
  std::vector<std::uint32_t> order_;  // by rank
  std::vector<float> x_, y_, z_;
  // Root first. Child c of node i is node 8 i + c of the next level.
  std::vector<std::vector<Node>> levels_;
};

}  // namespace surfit
