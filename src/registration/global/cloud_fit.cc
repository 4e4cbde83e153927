#include "registration/global/cloud_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "geometry/kd_tree.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kMinAgreeingCosine = 0.82f;  // 35 degrees

// Standard deviation of the points from the plane through them, m.
double PlaneDeviation(const KdTree& tree, const std::vector<KdTree::Neighbor>& found) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& neighbor : found) mean += tree.Point(neighbor.rank).cast<double>();
  const double count = static_cast<double>(found.size());
  mean /= count;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const auto& neighbor : found) {
    const Eigen::Vector3d offset = tree.Point(neighbor.rank).cast<double>() - mean;
    squares += offset * offset.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(squares);
  return std::sqrt(std::max(0., solver.eigenvalues()[0]) / (count - 3));
}

struct FreeSpaceCounts {
  int violations = 0, seen = 0;

  FreeSpaceCounts& operator+=(const FreeSpaceCounts& other) {
    violations += other.violations;
    seen += other.seen;
    return *this;
  }
};

}  // namespace

CloudScale MeasureScale(const std::vector<Eigen::Vector3f>& points) {
  constexpr std::size_t kNeighbors = 8, kPlaneNeighbors = 24, kSamples = 1000;
  const KdTree tree(points);
  CloudScale scale;
  if (tree.size() <= kPlaneNeighbors) return scale;
  const std::size_t step = std::max<std::size_t>(1, tree.size() / kSamples);
  std::vector<double> spacings, deviations;
  std::vector<KdTree::Neighbor> found;
  for (std::uint32_t i = 0; i < tree.size(); i += step) {
    tree.FindNearest(tree.Point(i), kPlaneNeighbors, &found);
    const double distance = std::sqrt(static_cast<double>(found[kNeighbors].squared_distance));
    if (!(distance > 0)) continue;  // equal points
    spacings.push_back(distance * std::sqrt(M_PI / kNeighbors));
    deviations.push_back(PlaneDeviation(tree, found));
  }
  scale.spacing_m = MedianOf(std::move(spacings));
  scale.noise_m = MedianOf(std::move(deviations));
  return scale;
}

struct CloudComparison::Data {
  Data(const PointSet& source, const PointSet& target) : tree(target.points) {
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (source.normals[i].isZero(0)) continue;
      points.push_back(source.points[i]);
      normals.push_back(source.normals[i]);
    }
    target_normals.reserve(target.size());
    for (const std::uint32_t i : tree.order()) target_normals.push_back(target.normals[i]);
  }

  // Compares source point i.
  ComparedPoint Compare(std::size_t i, const Eigen::Matrix3f& rotation,
                        const Eigen::Vector3f& translation) const {
    ComparedPoint compared;
    compared.point = rotation * points[i] + translation;
    compared.normal = rotation * normals[i];
    const KdTree::Neighbor match = tree.Nearest(compared.point, near2);
    if (match.rank == KdTree::kNone) return compared;
    const Eigen::Vector3f& n = target_normals[match.rank];
    if (n.isZero(0)) return compared;
    compared.is_near = true;
    const float cosine = n.dot(compared.normal);
    compared.is_on_surface = std::abs(n.dot(compared.point - tree.Point(match.rank))) < tolerance &&
                             (uses_signs ? cosine : std::abs(cosine)) > kMinAgreeingCosine;
    return compared;
  }

  KdTree tree;
  std::vector<Eigen::Vector3f> target_normals;  // in the order of the tree
  std::vector<Eigen::Vector3f> points, normals;
  float near2 = 0, tolerance = 0;
  bool uses_signs = false;
};

CloudComparison::CloudComparison(const PointSet& source, const PointSet& target,
                                 const ComparisonLimits& limits) {
  auto data = std::make_unique<Data>(source, target);
  data->near2 = static_cast<float>(limits.near_m * limits.near_m);
  data->tolerance = static_cast<float>(limits.tolerance_m);
  data->uses_signs = limits.uses_signs;
  data_ = std::move(data);
}

CloudComparison::~CloudComparison() = default;

std::vector<ComparedPoint> CloudComparison::PointsAt(const Rigid3d& target_from_source) const {
  const Eigen::Matrix3f rotation = target_from_source.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = target_from_source.translation.cast<float>();
  std::vector<ComparedPoint> compared(data_->points.size());
  ParallelFor(0, static_cast<int>(compared.size()), 256, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) compared[i] = data_->Compare(i, rotation, translation);
  });
  return compared;
}

CloudAgreement CloudComparison::At(const Rigid3d& target_from_source) const {
  int near = 0, on_surface = 0;
  const std::vector<ComparedPoint> compared = PointsAt(target_from_source);
  for (const ComparedPoint& point : compared) {
    near += point.is_near;
    on_surface += point.is_on_surface;
  }
  CloudAgreement agreement;
  if (compared.empty()) return agreement;
  agreement.overlap_ratio = static_cast<double>(on_surface) / static_cast<double>(compared.size());
  if (near > 0) agreement.inlier_ratio = static_cast<double>(on_surface) / near;
  return agreement;
}

double CloudComparison::Distance(const Rigid3d& a, const Rigid3d& b) const {
  double sum = 0;
  for (const Eigen::Vector3f& point : data_->points) {
    const Eigen::Vector3d p = point.cast<double>();
    sum += (a * p - b * p).squaredNorm();
  }
  return data_->points.empty() ? 0 : std::sqrt(sum / static_cast<double>(data_->points.size()));
}

RangeImage::Pixel RangeImage::PixelOf(const Eigen::Vector3d& direction) const {
  int axis = 0;
  const double largest = direction.cwiseAbs().maxCoeff(&axis);
  const auto pixel = [&](double component) {
    return std::clamp(static_cast<int>((component / largest + 1) * 0.5 * size_), 0, size_ - 1);
  };
  return {2 * axis + (direction[axis] < 0 ? 1 : 0), pixel(direction[(axis + 1) % 3]),
          pixel(direction[(axis + 2) % 3])};
}

std::size_t RangeImage::Index(const Pixel& pixel) const {
  return (static_cast<std::size_t>(pixel.face) * size_ + pixel.v) * size_ + pixel.u;
}

float RangeImage::FreeRange(const Pixel& pixel) const {
  float range = nearest_[Index(pixel)];
  if (!(range > 0)) return 0;
  for (int v = std::max(0, pixel.v - 1); v <= std::min(size_ - 1, pixel.v + 1); ++v) {
    for (int u = std::max(0, pixel.u - 1); u <= std::min(size_ - 1, pixel.u + 1); ++u) {
      const float other = nearest_[Index({pixel.face, u, v})];
      if (other > 0) range = std::min(range, other);
    }
  }
  return range;
}

RangeImage::RangeImage(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& viewpoint,
                       double spacing_m)
    : viewpoint_(viewpoint) {
  // A pixel covers about nine points of a surface at the median distance.
  constexpr double kSpacingsPerPixel = 3;
  constexpr int kLargest = 512;
  std::vector<double> ranges;
  ranges.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    ranges.push_back((point.cast<double>() - viewpoint).norm());
  }
  const double range_m = MedianOf(std::move(ranges));
  if (!(range_m > 0) || !(spacing_m > 0)) return;
  size_ = std::clamp(static_cast<int>(2 * range_m / (kSpacingsPerPixel * spacing_m)), 8, kLargest);
  nearest_.assign(static_cast<std::size_t>(6) * size_ * size_, 0.f);
  farthest_ = nearest_;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d direction = point.cast<double>() - viewpoint;
    const auto range = static_cast<float>(direction.norm());
    if (!(range > 0)) continue;
    const std::size_t i = Index(PixelOf(direction));
    nearest_[i] = nearest_[i] > 0 ? std::min(nearest_[i], range) : range;
    farthest_[i] = std::max(farthest_[i], range);
  }
}

RangeImage::Visibility RangeImage::VisibilityOf(const Eigen::Vector3d& point,
                                                double tolerance_m) const {
  if (size_ == 0) return Visibility::kUnknown;
  const Eigen::Vector3d direction = point - viewpoint_;
  const double range = direction.norm();
  if (!(range > 0)) return Visibility::kUnknown;
  const Pixel pixel = PixelOf(direction);
  const float free = FreeRange(pixel);
  if (!(free > 0)) return Visibility::kUnknown;
  if (range > farthest_[Index(pixel)] + tolerance_m) return Visibility::kHidden;
  return range < free - tolerance_m ? Visibility::kFreeSpace : Visibility::kSurface;
}

double RangeImage::ViolationRatio(const std::vector<Eigen::Vector3f>& points, const Rigid3d& pose,
                                  double tolerance_m) const {
  const FreeSpaceCounts counts = ParallelSum(
      0, static_cast<int>(points.size()), 1024, FreeSpaceCounts(), [&](int begin, int end) {
        FreeSpaceCounts sum;
        for (int i = begin; i < end; ++i) {
          const Visibility visibility = VisibilityOf(pose * points[i].cast<double>(), tolerance_m);
          sum.violations += visibility == Visibility::kFreeSpace;
          sum.seen += visibility == Visibility::kFreeSpace || visibility == Visibility::kSurface;
        }
        return sum;
      });
  return counts.seen > 0 ? static_cast<double>(counts.violations) / counts.seen : 0;
}

}  // namespace surfit
