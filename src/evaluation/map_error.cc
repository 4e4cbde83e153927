#include "surfit/evaluation/map_error.h"

#include <glog/logging.h>

#include <cmath>

#include "evaluation/morton_order.h"
#include "evaluation/nearest_point.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr int kGrain = 4096;

struct Cloud {
  Points points;
  Points normals;  // or empty
};

// The points with finite coordinates and their normals, neighbours in space near in memory.
Cloud Prepare(const Points& points, const Points& normals, const char* name) {
  if (points.size() > std::size_t{1} << 30) {
    throw InputError(Concat("the ", name, " has ", points.size(), " points, must be at most 2^30"));
  }
  Points finite_points, finite_normals;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    finite_points.push_back(points[i]);
    if (!normals.empty()) finite_normals.push_back(normals[i]);
  }
  if (finite_points.empty()) throw InputError(Concat("the ", name, " has no finite point"));
  Cloud cloud;
  cloud.points.reserve(finite_points.size());
  cloud.normals.reserve(finite_normals.size());
  for (const std::uint32_t i : MortonOrder(finite_points)) {
    cloud.points.push_back(finite_points[i]);
    if (!normals.empty()) cloud.normals.push_back(finite_normals[i]);
  }
  return cloud;
}

// Accuracy, to points and to planes.
void MeasureAccuracy(const Points& map, const Cloud& reference, const NearestPoint& tree,
                     MapError* error) {
  const int count = static_cast<int>(map.size());
  const bool has_planes = !reference.normals.empty();
  std::vector<double> to_point_m(count), to_plane_m(has_planes ? count : 0);
  ParallelFor(0, count, kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::uint32_t nearest = tree.Find(map[i]);
      const Eigen::Vector3d offset =
          map[i].cast<double>() - reference.points[nearest].cast<double>();
      to_point_m[i] = offset.norm();
      if (!has_planes) continue;
      to_plane_m[i] = std::abs(reference.normals[nearest].cast<double>().dot(offset));
    }
  });
  error->accuracy_m = Summarize(std::move(to_point_m));
  if (has_planes) error->plane_accuracy_m = Summarize(std::move(to_plane_m));
}

double MeasureCompleteness(const Points& reference, const NearestPoint& tree, double distance_m) {
  const int count = static_cast<int>(reference.size());
  const auto mapped = ParallelSum(0, count, kGrain, 0, [&](int begin, int end) {
    int sum = 0;
    for (int i = begin; i < end; ++i) {
      sum += tree.HasWithin(reference[i], static_cast<float>(distance_m)) ? 1 : 0;
    }
    return sum;
  });
  return static_cast<double>(mapped) / count;
}

}  // namespace

void MapErrorOptions::Validate() const {
  if (!(std::isfinite(completeness_distance_m) && completeness_distance_m > 0)) {
    throw InputError(Concat("completeness_distance_m is ", completeness_distance_m,
                            ", must be finite and positive"));
  }
}

MapError ComputeMapError(const std::vector<Eigen::Vector3f>& map,
                         const std::vector<Eigen::Vector3f>& reference,
                         const std::vector<Eigen::Vector3f>& reference_normals,
                         const MapErrorOptions& options) {
  options.Validate();
  CHECK(reference_normals.empty() || reference_normals.size() == reference.size());
  const Cloud finite_map = Prepare(map, {}, "map");
  const Cloud finite_reference = Prepare(reference, reference_normals, "reference");
  MapError error;
  error.map_points = finite_map.points.size();
  error.reference_points = finite_reference.points.size();
  std::unique_ptr<NearestPoint> map_tree, reference_tree;
  ParallelFor(0, 2, 1, [&](int i, int) {
    if (i == 0) reference_tree = std::make_unique<NearestPoint>(finite_reference.points);
    if (i == 1) map_tree = std::make_unique<NearestPoint>(finite_map.points);
  });
  MeasureAccuracy(finite_map.points, finite_reference, *reference_tree, &error);
  error.completeness =
      MeasureCompleteness(finite_reference.points, *map_tree, options.completeness_distance_m);
  return error;
}

}  // namespace surfit
