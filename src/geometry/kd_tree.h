#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace surfit {

// A balanced KD-tree (Friedman, Bentley and Finkel 1977) over points in single precision. A node
// holds the tight boxes of eight children, three binary splits in one; they and the points are
// tested four at a time.
//
// What is found is exact in the arithmetic of SquaredDistance() and so does not depend on where a
// search starts: the distance to a box is computed by the same operations, which round
// monotonically, and never exceeds that to a point in it.
//
// The tree keeps a copy of the points in an order of its own, in which points that follow each
// other lie near each other, and names them by their rank in it. Queries that come in the order of
// another tree find memory in the cache. They are safe from many threads.
class KdTree {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr float kAnyDistance = std::numeric_limits<float>::infinity();

  struct Neighbor {
    std::uint32_t rank = kNone;
    float squared_distance = kAnyDistance;
  };

  // Takes finite points, fewer than 2^31. Built by all threads, and the same at any number of them.
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);

  std::size_t size() const { return order_.size(); }
  // Where the point of each rank stood in what the tree was made from.
  const std::vector<std::uint32_t>& order() const { return order_; }
  Eigen::Vector3f Point(std::uint32_t rank) const { return {x_[rank], y_[rank], z_[rank]}; }

  // dx^2 + dy^2 + dz^2 from left to right, each operation rounded to single precision.
  float SquaredDistance(const Eigen::Vector3f& query, std::uint32_t rank) const {
    const float dx = query.x() - x_[rank], dy = query.y() - y_[rank], dz = query.z() - z_[rank];
    return dx * dx + dy * dy + dz * dz;
  }

  // The nearest point at most that far; of equally near ones the first in order(). The nearer the
  // point of rank `hint`, the less there is to search.
  Neighbor Nearest(const Eigen::Vector3f& query, float max_squared_distance = kAnyDistance,
                   std::uint32_t hint = kNone) const;

  // Replaces `ranks` by those of all points at most that far, in ascending order.
  void FindWithin(const Eigen::Vector3f& query, float max_squared_distance,
                  std::vector<std::uint32_t>* ranks) const;

 private:
  static constexpr int kWidth = 4;     // tested at once
  static constexpr int kChildren = 8;  // of a node

  struct Box;
  // The sides of the children's boxes by axis; NaN, which is within no distance, where the root has
  // fewer children.
  struct Node {
    Node();
    float low[3][kChildren], high[3][kChildren];
  };
  class Sorter;
  class Search;
  class NearestSearch;
  class RangeSearch;

  void MakeNodes();
  std::uint32_t LeafBegin(std::uint64_t leaf) const {
    return static_cast<std::uint32_t>(leaf * order_.size() >> depth_);
  }

  int depth_ = 0;                          // binary splits above each of the 2^depth leaves
  std::vector<std::uint32_t> order_;       // by rank
  std::vector<float> x_, y_, z_;           // by rank; padded by a few lanes of NaN
  std::vector<std::vector<Node>> levels_;  // the root's first; child c of node i is 8 i + c below
};

}  // namespace surfit
