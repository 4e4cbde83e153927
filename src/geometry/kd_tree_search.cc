
#include <algorithm>

#include "geometry/float4.h"
#include "geometry/kd_tree.h"

namespace surfit {

class KdTree::Search {
 protected:
  Search(const KdTree& tree, const Eigen::Vector3f& query)
      : tree_(tree), x_(AllLanes(query.x())), y_(AllLanes(query.y())), z_(AllLanes(query.z())) {}

  bool IsLeaf(std::size_t level) const { return level == tree_.levels_.size(); }

  // Bit c of the result is set if child c is within `bound`.
  unsigned ChildrenWithin(std::size_t level, std::uint32_t index, float bound,
                          float* distances) const {
    const Node& node = tree_.levels_[level][index];
    unsigned bits = 0;
    for (int c = 0; c < kChildren; c += kWidth) {
      const Float4 distance = Square(Outside(&node.low[0][c], &node.high[0][c], x_)) +
                              Square(Outside(&node.low[1][c], &node.high[1][c], y_)) +
                              Square(Outside(&node.low[2][c], &node.high[2][c], z_));
      Store4(distance, distances + c);
      bits |= Bits(distance <= bound) << c;
    }
    return bits;
  }

  // Child with the smallest distance among the set bits of `children`, which is not 0.
  static int Nearest(unsigned children, const float* distances) {
    int nearest = __builtin_ctz(children);
    for (unsigned bits = children & (children - 1); bits != 0; bits &= bits - 1) {
      const int child = __builtin_ctz(bits);
      if (distances[child] < distances[nearest]) nearest = child;
    }
    return nearest;
  }

  // Computes squared distances to four points with consecutive ranks. Bit i of the result is set if
  // point `rank` + i is within `bound`.
  unsigned PointsWithin(std::uint32_t rank, float bound, float* distances) const {
    const Float4 distance = Square(x_ - Load4(&tree_.x_[rank])) +
                            Square(y_ - Load4(&tree_.y_[rank])) +
                            Square(z_ - Load4(&tree_.z_[rank]));
    Store4(distance, distances);
    return Bits(distance <= bound);
  }

  const KdTree& tree_;

 private:
  static Float4 Square(Float4 a) { return a * a; }
  static Float4 Outside(const float* low, const float* high, Float4 coordinate) {
    return Max(Max(Load4(low) - coordinate, coordinate - Load4(high)), Float4{});
  }

  Float4 x_, y_, z_;
};

class KdTree::NearestSearch : private Search {
 public:
  NearestSearch(const KdTree& tree, const Eigen::Vector3f& query, const Neighbor& start)
      : Search(tree, query), best_(start) {}

  Neighbor Run() {
    Visit(0, 0);
    return best_;
  }

 private:
  // Visits the nearest children first, so that far children can be skipped.
  void Visit(std::size_t level, std::uint32_t index) {
    if (IsLeaf(level)) return VisitLeaf(index);
    alignas(16) float distances[kChildren];
    unsigned rest = ChildrenWithin(level, index, best_.squared_distance, distances);
    while (rest != 0) {
      const int nearest = Nearest(rest, distances);
      if (distances[nearest] > best_.squared_distance) return;
      rest &= ~(1u << nearest);
      Visit(level + 1, kChildren * index + nearest);
    }
  }

  // Vector lanes after the end of the leaf contain points of the next leaf, which are valid
  // candidates.
  void VisitLeaf(std::uint32_t leaf) {
    alignas(16) float distances[kWidth];
    const std::uint32_t end = tree_.LeafBegin(std::uint64_t{leaf} + 1);
    for (std::uint32_t rank = tree_.LeafBegin(leaf); rank < end; rank += kWidth) {
      unsigned bits = PointsWithin(rank, best_.squared_distance, distances);
      for (; bits != 0; bits &= bits - 1) {
        const int lane = __builtin_ctz(bits);
        Consider(rank + lane, distances[lane]);
      }
    }
  }

  void Consider(std::uint32_t rank, float squared_distance) {
    const bool nearer = squared_distance < best_.squared_distance;
    const bool first_of_equals =
        squared_distance == best_.squared_distance &&
        (best_.rank == kNone || tree_.order_[rank] < tree_.order_[best_.rank]);
    if (nearer || first_of_equals) best_ = {rank, squared_distance};
  }

  Neighbor best_;
};

class KdTree::FewNearestSearch : private Search {
 public:
  FewNearestSearch(const KdTree& tree, const Eigen::Vector3f& query, std::size_t count,
                   std::vector<Neighbor>* neighbors)
      : Search(tree, query), count_(std::min(count, tree.size())), neighbors_(*neighbors) {}

  void Run() {
    neighbors_.clear();
    if (count_ > 0) Visit(0, 0);
  }

 private:
  float Bound() const {
    return neighbors_.size() < count_ ? kAnyDistance : neighbors_.back().squared_distance;
  }
  // Equal distances do not change a complete list. Subtrees of equal points are therefore skipped.
  bool IsUseless(float squared_distance) const {
    return neighbors_.size() == count_ && !(squared_distance < Bound());
  }

  void Visit(std::size_t level, std::uint32_t index) {
    if (IsLeaf(level)) return VisitLeaf(index);
    alignas(16) float distances[kChildren];
    unsigned rest = ChildrenWithin(level, index, Bound(), distances);
    while (rest != 0) {
      const int nearest = Nearest(rest, distances);
      if (IsUseless(distances[nearest])) return;
      rest &= ~(1u << nearest);
      Visit(level + 1, kChildren * index + nearest);
    }
  }

  void VisitLeaf(std::uint32_t leaf) {
    alignas(16) float distances[kWidth];
    const std::uint32_t end = tree_.LeafBegin(std::uint64_t{leaf} + 1);
    for (std::uint32_t rank = tree_.LeafBegin(leaf); rank < end; rank += kWidth) {
      unsigned bits = PointsWithin(rank, Bound(), distances);
      for (; bits != 0; bits &= bits - 1) {
        const int lane = __builtin_ctz(bits);
        if (rank + lane < end) Consider({rank + lane, distances[lane]});
      }
    }
  }

  void Consider(const Neighbor& neighbor) {
    if (IsUseless(neighbor.squared_distance)) return;
    if (neighbors_.size() == count_) neighbors_.pop_back();
    auto place = neighbors_.end();
    while (place != neighbors_.begin() &&
           neighbor.squared_distance < (place - 1)->squared_distance) {
      --place;
    }
    neighbors_.insert(place, neighbor);
  }

  std::size_t count_;
  std::vector<Neighbor>& neighbors_;
};

class KdTree::RangeSearch : private Search {
 public:
  RangeSearch(const KdTree& tree, const Eigen::Vector3f& query, float bound,
              std::vector<std::uint32_t>* ranks)
      : Search(tree, query), bound_(bound), ranks_(*ranks) {}

  void Visit(std::size_t level, std::uint32_t index) {
    if (IsLeaf(level)) return VisitLeaf(index);
    alignas(16) float distances[kChildren];
    unsigned rest = ChildrenWithin(level, index, bound_, distances);
    for (; rest != 0; rest &= rest - 1) Visit(level + 1, kChildren * index + __builtin_ctz(rest));
  }

 private:
  void VisitLeaf(std::uint32_t leaf) {
    alignas(16) float distances[kWidth];
    const std::uint32_t end = tree_.LeafBegin(std::uint64_t{leaf} + 1);
    for (std::uint32_t rank = tree_.LeafBegin(leaf); rank < end; rank += kWidth) {
      for (unsigned bits = PointsWithin(rank, bound_, distances); bits != 0; bits &= bits - 1) {
        const std::uint32_t found = rank + __builtin_ctz(bits);
        if (found < end) ranks_.push_back(found);
      }
    }
  }

  float bound_;
  std::vector<std::uint32_t>& ranks_;
};

KdTree::Neighbor KdTree::Nearest(const Eigen::Vector3f& query, float max_squared_distance,
                                 std::uint32_t hint) const {
  Neighbor start{kNone, max_squared_distance};
  if (hint != kNone) {
    const float squared_distance = SquaredDistance(query, hint);
    if (squared_distance <= max_squared_distance) start = {hint, squared_distance};
  }
  return NearestSearch(*this, query, start).Run();
}

void KdTree::FindNearest(const Eigen::Vector3f& query, std::size_t count,
                         std::vector<Neighbor>* neighbors) const {
  FewNearestSearch(*this, query, count, neighbors).Run();
}

void KdTree::FindWithin(const Eigen::Vector3f& query, float max_squared_distance,
                        std::vector<std::uint32_t>* ranks) const {
  ranks->clear();
  RangeSearch(*this, query, max_squared_distance, ranks).Visit(0, 0);
}

}  // namespace surfit
