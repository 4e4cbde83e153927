#include "geometry/kd_tree.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxPointsInLeaf = 32;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

struct KdTree::Box {
  Eigen::Array3f low = Eigen::Array3f::Constant(kAnyDistance);
  Eigen::Array3f high = -low;

  void Include(const Eigen::Array3f& other_low, const Eigen::Array3f& other_high) {
    low = low.min(other_low);
    high = high.max(other_high);
  }
};

class KdTree::Sorter {
 public:
  struct Item {
    Eigen::Vector3f point;
    std::uint32_t position;
  };

  Sorter(const KdTree& tree, std::vector<Item>* items) : tree_(tree), items_(items->data()) {}

  void Run() const {
    // Each node near the root is one task. Each subtree below these nodes is one task.
    const int levels = std::min(tree_.depth_, 6);
    int subtree_leaves = 1 << tree_.depth_;
    for (int level = 0; level < levels; ++level, subtree_leaves /= 2) {
      ParallelFor(0, 1 << level, 1,
                  [&](int node, int) { Split(node * subtree_leaves, subtree_leaves); });
    }
    ParallelFor(0, 1 << levels, 1,
                [&](int node, int) { Sort(node * subtree_leaves, subtree_leaves); });
  }

 private:
  void Split(int first_leaf, int leaves) const {
    Item* const begin = items_ + tree_.LeafBegin(first_leaf);
    Item* const middle = items_ + tree_.LeafBegin(first_leaf + leaves / 2);
    Item* const end = items_ + tree_.LeafBegin(first_leaf + leaves);
    Box box;
    for (const Item* item = begin; item != end; ++item) box.Include(item->point, item->point);
    int axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    std::nth_element(begin, middle, end, [axis](const Item& a, const Item& b) {
      return a.point[axis] < b.point[axis];
    });
  }

  void Sort(int first_leaf, int leaves) const {
    if (leaves == 1) return;
    Split(first_leaf, leaves);
    Sort(first_leaf, leaves / 2);
    Sort(first_leaf + leaves / 2, leaves / 2);
  }

  const KdTree& tree_;
  Item* items_;
};

KdTree::KdTree(const std::vector<Eigen::Vector3f>& points) {
  CHECK_LT(points.size(), std::size_t{1} << 31);
  while (points.size() > kMaxPointsInLeaf << depth_) ++depth_;
  std::vector<Sorter::Item> items(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    items[i] = {points[i], static_cast<std::uint32_t>(i)};
  }
  order_.resize(points.size());
  Sorter(*this, &items).Run();
  for (auto* axis : {&x_, &y_, &z_}) axis->assign(points.size() + kWidth, kNan);
  for (std::size_t rank = 0; rank < items.size(); ++rank) {
    order_[rank] = items[rank].position;
    x_[rank] = items[rank].point.x();
    y_[rank] = items[rank].point.y();
    z_[rank] = items[rank].point.z();
  }
  MakeNodes();
}

void KdTree::MakeNodes() {
  std::vector<Box> boxes(std::size_t{1} << depth_);
  ParallelFor(0, static_cast<int>(boxes.size()), 1024, [&](int begin, int end) {
    for (int leaf = begin; leaf < end; ++leaf) {
      for (std::uint32_t rank = LeafBegin(leaf); rank < LeafBegin(leaf + 1); ++rank) {
        boxes[leaf].Include(Point(rank), Point(rank));
      }
    }
  });
  while (boxes.size() > 1) {
    std::vector<Node> nodes((boxes.size() + kChildren - 1) / kChildren);
    std::vector<Box> around(nodes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        nodes[i / kChildren].low[axis][i % kChildren] = boxes[i].low[axis];
        nodes[i / kChildren].high[axis][i % kChildren] = boxes[i].high[axis];
      }
      around[i / kChildren].Include(boxes[i].low, boxes[i].high);
    }
    levels_.insert(levels_.begin(), std::move(nodes));
    boxes = std::move(around);
  }
}

KdTree::Node::Node() {
  for (auto* sides : {&low, &high}) {
    for (auto& side : *sides) std::fill(std::begin(side), std::end(side), kNan);
  }
}

}  // namespace surfit
