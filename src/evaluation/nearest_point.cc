#include "evaluation/nearest_point.h"

#include <glog/logging.h>

#include <cmath>
#include <limits>
#include <nanoflann.hpp>

namespace surfit {
namespace {

// What nanoflann asks of a cloud.
struct Cloud {
  const std::vector<Eigen::Vector3f>& points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// A nanoflann result set that ends the search at the first point that is near enough.
class AnyWithin {
 public:
  using DistanceType = float;
  // nanoflann offers points below the worst distance only, not at it.
  explicit AnyWithin(float distance)
      : worst_(std::nextafter(distance * distance, std::numeric_limits<float>::infinity())) {}

  bool addPoint(float, std::uint32_t) {
    found_ = true;
    return false;
  }
  float worstDist() const { return worst_; }
  bool full() const { return found_; }

 private:
  float worst_;
  bool found_ = false;
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<float, Cloud, float, std::uint32_t>, Cloud, 3, std::uint32_t>;

}  // namespace

struct NearestPoint::Tree {
  explicit Tree(const std::vector<Eigen::Vector3f>& points)
      : cloud{points}, index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
  Cloud cloud;
  Index index;
};

NearestPoint::NearestPoint(const std::vector<Eigen::Vector3f>& points) {
  CHECK(!points.empty());
  CHECK_LT(points.size(), std::size_t{1} << 31);
  tree_ = std::make_unique<Tree>(points);
}

NearestPoint::~NearestPoint() = default;

std::uint32_t NearestPoint::Find(const Eigen::Vector3f& query) const {
  std::uint32_t nearest = 0;
  float squared_distance = 0;
  nanoflann::KNNResultSet<float, std::uint32_t> result(1);
  result.init(&nearest, &squared_distance);
  tree_->index.findNeighbors(result, query.data(), nanoflann::SearchParams());
  return nearest;
}

bool NearestPoint::HasWithin(const Eigen::Vector3f& query, float distance) const {
  AnyWithin result(distance);
  return tree_->index.findNeighbors(result, query.data(), nanoflann::SearchParams());
}

}  // namespace surfit
