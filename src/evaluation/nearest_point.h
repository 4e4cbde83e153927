#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace surfit {

// A KD-tree over points, which must outlive it: finite, at least one, fewer than 2^31.
// Queries are safe from many threads.
class NearestPoint {
 public:
  explicit NearestPoint(const std::vector<Eigen::Vector3f>& points);
  ~NearestPoint();

  // The position of the nearest point; which of several that are equally near is not specified,
  // but always the same.
  std::uint32_t Find(const Eigen::Vector3f& query) const;
  // Whether any point is at most that far.
  bool HasWithin(const Eigen::Vector3f& query, float distance) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace surfit
