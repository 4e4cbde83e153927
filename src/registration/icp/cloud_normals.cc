#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "geometry/kd_tree.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {
namespace {

constexpr int kPointsPerTask = 512;
constexpr double kRadiusStep = M_SQRT2;
constexpr double kLeastWidth = 0.01;  // minimum width / length of a neighbourhood; below: line

// Point `to` relative to point `from`. The difference avoids cancellation far from the origin.
Eigen::Vector3d Offset(const KdTree& tree, std::uint32_t from, std::uint32_t to) {
  return tree.Point(to).cast<double>() - tree.Point(from).cast<double>();
}

float SquaredBound(double radius_m) { return static_cast<float>(radius_m * radius_m); }

// Median point spacing of the cloud, m; 0: too few points. Assumes that k neighbours within radius
// r share the area pi r^2. Samples with many equal points are skipped.
double Spacing(const KdTree& tree) {
  constexpr std::size_t kNeighbors = 8, kSamples = 500;
  if (tree.size() <= kNeighbors) return 0;
  const std::size_t step = std::max<std::size_t>(1, tree.size() / kSamples);
  std::vector<double> spacings;
  std::vector<KdTree::Neighbor> found;
  for (std::uint32_t i = 0; i < tree.size(); i += step) {
    tree.FindNearest(tree.Point(i), kNeighbors + 1, &found);
    const double distance = Offset(tree, i, found.back().rank).norm();
    if (distance > 0) spacings.push_back(distance * std::sqrt(M_PI / kNeighbors));
  }
  return MedianOf(std::move(spacings));
}

struct Plane {
  bool good = false;
  Eigen::Vector3d normal;
  double deviation_m = 0;
};

Plane FitPlane(const KdTree& tree, const Eigen::Vector3f& center,
               const std::vector<std::uint32_t>& found, const CloudNormalOptions& options) {
  Plane plane;
  const double count = static_cast<double>(found.size());
  if (count < options.min_neighbors) return plane;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const std::uint32_t i : found) {
    const Eigen::Vector3d offset = tree.Point(i).cast<double>() - center.cast<double>();
    sum += offset;
    squares += offset * offset.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(squares / count - sum * sum.transpose() / (count * count));
  const double least = std::max(0., solver.eigenvalues()[0]), middle = solver.eigenvalues()[1];
  if (!(middle > kLeastWidth * kLeastWidth * solver.eigenvalues()[2])) return plane;
  const double thickness = std::sqrt(least / middle);
  plane.good = thickness <= options.max_thickness &&
               thickness <= options.max_normal_sigma_rad * std::sqrt(count - 3);
  plane.normal = solver.eigenvectors().col(0);
  plane.deviation_m = std::sqrt(least * count / (count - 3));
  return plane;
}

class PlaneFinder {
 public:
  PlaneFinder(const std::vector<Eigen::Vector3f>& points, const CloudSensor& sensor,
              const CloudNormalOptions& options)
      : sensor_(sensor), options_(options) {
    thinned_.emplace_back(points);
    radius_m_ =
        options.radius_m > 0 ? options.radius_m : CloudNormalOptions::kSpacings * Spacing(all());
    while (thinned_.back().size() > kThinnest) thinned_.push_back(Thinned(thinned_.back()));
  }

  const KdTree& all() const { return thinned_.front(); }
  double radius_m() const { return radius_m_; }

  // Returns the plane of the smallest radius with a good fit. If no fit is good, `good` is false.
  Plane Find(const Eigen::Vector3f& point, std::vector<std::uint32_t>* found) const {
    const double distance_m = (point.cast<double>() - sensor_.viewpoint).norm();
    const double noise_radius_m = 2 * sensor_.noise.SigmaZ(distance_m) / options_.max_thickness;
    const double largest_m = options_.max_growth * radius_m_ * (1 + 1e-9);
    Plane plane;
    if (!(radius_m_ > 0)) return plane;  // too few points, or all at the same position
    for (double radius_m = std::clamp(noise_radius_m, radius_m_, options_.max_growth * radius_m_);
         !plane.good && radius_m <= largest_m; radius_m *= kRadiusStep) {
      plane = FitPlane(FindNeighbors(point, radius_m, found), point, *found, options_);
    }
    return plane;
  }

 private:
  static constexpr std::size_t kThinnest = 256;  // points of the thinnest tree

  // Keeps every fourth point in tree order, which samples the whole cloud.
  static KdTree Thinned(const KdTree& tree) {
    std::vector<Eigen::Vector3f> points;
    for (std::uint32_t i = 0; i < tree.size(); i += 4) points.push_back(tree.Point(i));
    return KdTree(points);
  }

  // Bounds the number of neighbours at any density, so the time per point is O(log n). Starts with
  // the thinnest tree. Continues with trees of 4 or 16 times the points until there are enough
  // neighbours.
  const KdTree& FindNeighbors(const Eigen::Vector3f& point, double radius_m,
                              std::vector<std::uint32_t>* found) const {
    constexpr std::size_t kEnough = 64;
    std::size_t tree = thinned_.size() - 1;
    for (;;) {
      thinned_[tree].FindWithin(point, SquaredBound(radius_m), found);
      if (tree == 0 || found->size() >= kEnough) return thinned_[tree];
      tree -= std::min<std::size_t>(tree, found->size() * 16 < kEnough ? 2 : 1);
    }
  }

  const CloudSensor& sensor_;
  const CloudNormalOptions& options_;
  std::vector<KdTree> thinned_;
  double radius_m_ = 0;
};

}  // namespace

CloudNormals EstimateCloudNormals(const std::vector<Eigen::Vector3f>& points,
                                  const CloudSensor& sensor, const CloudNormalOptions& options) {
  Validate(options);
  const PlaneFinder finder(points, sensor, options);
  const KdTree& tree = finder.all();
  CloudNormals result;
  result.normals.assign(points.size(), Eigen::Vector3f::Zero());
  result.deviation_m.assign(points.size(), 0.f);
  result.radius_m = finder.radius_m();
  const int count = static_cast<int>(points.size());
  result.missing = ParallelSum(0, count, kPointsPerTask, 0, [&](int begin, int end) {
    int missing = 0;
    std::vector<std::uint32_t> found;
    for (int rank = begin; rank < end; ++rank) {
      const Plane plane = finder.Find(tree.Point(rank), &found);
      if (!plane.good) {
        ++missing;
        continue;
      }
      const Eigen::Vector3d to_viewpoint = sensor.viewpoint - tree.Point(rank).cast<double>();
      const double sign = plane.normal.dot(to_viewpoint) < 0 ? -1 : 1;
      const std::uint32_t i = tree.order()[rank];
      result.normals[i] = (sign * plane.normal).cast<float>();
      result.deviation_m[i] = static_cast<float>(plane.deviation_m);
    }
    return missing;
  });
  return result;
}

}  // namespace surfit
