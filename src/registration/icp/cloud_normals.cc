#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/kd_tree.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/register_clouds.h"

namespace surfit {
namespace {

constexpr int kGrain = 512;
constexpr double kRadiusStep = M_SQRT2;
constexpr double kLeastWidth = 0.01;  // minimum width / length of a neighbourhood; below: line

// Point `to` relative to point `from`. The difference avoids cancellation far from the origin.
Eigen::Vector3d Offset(const KdTree& tree, std::uint32_t from, std::uint32_t to) {
  return tree.Point(to).cast<double>() - tree.Point(from).cast<double>();
}

float SquaredBound(double radius_m) { return static_cast<float>(radius_m * radius_m); }

// Median point spacing of the cloud, m; 0: too few points. Assumes that k neighbours within radius
// r share the area pi r^2.
double Spacing(const KdTree& tree) {
  constexpr std::size_t kNeighbors = 8, kSamples = 500;
  if (tree.size() <= kNeighbors) return 0;
  Eigen::Vector3d low = tree.Point(0).cast<double>(), high = low;
  for (std::uint32_t i = 0; i < tree.size(); ++i) {
    low = low.cwiseMin(tree.Point(i).cast<double>());
    high = high.cwiseMax(tree.Point(i).cast<double>());
  }
  const double extent = (high - low).norm();
  const std::size_t step = std::max<std::size_t>(1, tree.size() / kSamples);
  std::vector<double> spacings;
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < tree.size(); i += step) {
    double radius = extent / 4096;
    do {
      tree.FindWithin(tree.Point(i), SquaredBound(radius), &found);
      radius *= 2;
    } while (found.size() <= kNeighbors && radius <= 4 * extent);
    if (found.size() <= kNeighbors) continue;
    std::vector<double> distances;
    distances.reserve(found.size());
    for (const std::uint32_t j : found) distances.push_back(Offset(tree, i, j).norm());
    std::nth_element(distances.begin(), distances.begin() + kNeighbors, distances.end());
    spacings.push_back(distances[kNeighbors] * std::sqrt(M_PI / kNeighbors));
  }
  if (spacings.empty()) return 0;
  const auto middle = spacings.begin() + spacings.size() / 2;
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
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
    while (thinned_.size() < kTrees) thinned_.push_back(Thinned(thinned_.back()));
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
      const KdTree& tree = TreeFor(radius_m);
      tree.FindWithin(point, SquaredBound(radius_m), found);
      plane = FitPlane(tree, point, *found, options_);
    }
    return plane;
  }

 private:
  static constexpr int kTrees = 6;

  // Keeps every fourth point in tree order, which samples the whole cloud.
  static KdTree Thinned(const KdTree& tree) {
    std::vector<Eigen::Vector3f> points;
    for (std::uint32_t i = 0; i < tree.size(); i += 4) points.push_back(tree.Point(i));
    return KdTree(points);
  }

  // Returns the tree for searches within `radius_m`. Thinned trees limit the number of neighbours
  // to a few hundred. Radii below four times the initial radius use all points. Each further
  // doubling of the radius uses a quarter of the points.
  const KdTree& TreeFor(double radius_m) const {
    const int doublings = static_cast<int>(std::log2(radius_m / radius_m_ + 1e-9));
    return thinned_[std::clamp(doublings - 1, 0, kTrees - 1)];
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
  result.missing = ParallelSum(0, count, kGrain, 0, [&](int begin, int end) {
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
