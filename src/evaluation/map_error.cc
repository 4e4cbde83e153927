#include "surfit/evaluation/map_error.h"

#include <cmath>

#include "evaluation/triangle_tree.h"
#include "geometry/kd_tree.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr int kSamplesPerTask = 4096;
constexpr std::size_t kMaxSurfaceSamples = 4'000'000;

struct Cloud {
  KdTree tree;
  Points normals;  // in the order of the tree; may be empty
};

Cloud Prepare(const Points& points, const Points& normals, const char* name) {
  ThrowIf(points.size() > std::size_t{1} << 30, "the ", name, " has ", points.size(),
          " points, must be at most 2^30");
  Points finite_points, finite_normals;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    finite_points.push_back(points[i]);
    if (!normals.empty()) finite_normals.push_back(normals[i]);
  }
  ThrowIf(finite_points.empty(), "the ", name, " has no finite point");
  Cloud cloud{KdTree(finite_points), {}};
  if (!normals.empty()) {
    for (const std::uint32_t i : cloud.tree.order()) cloud.normals.push_back(finite_normals[i]);
  }
  return cloud;
}

void MeasureAccuracy(const Cloud& map, const Cloud& reference, MapError* error) {
  const int count = static_cast<int>(map.tree.size());
  const bool has_planes = !reference.normals.empty();
  std::vector<double> to_point_m(count), to_plane_m(has_planes ? count : 0);
  ParallelFor(0, count, kSamplesPerTask, [&](int begin, int end) {
    std::uint32_t nearest = KdTree::kNone;
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3f point = map.tree.Point(i);
      nearest = reference.tree.Nearest(point, KdTree::kAnyDistance, nearest).rank;
      const Eigen::Vector3d offset =
          point.cast<double>() - reference.tree.Point(nearest).cast<double>();
      to_point_m[i] = offset.norm();
      if (!has_planes) continue;
      to_plane_m[i] = std::abs(reference.normals[nearest].cast<double>().dot(offset));
    }
  });
  error->accuracy_m = Summarize(std::move(to_point_m));
  if (has_planes) error->plane_accuracy_m = Summarize(std::move(to_plane_m));
}

double MeasureCompleteness(const Cloud& reference, const Cloud& map, double distance_m) {
  const int count = static_cast<int>(reference.tree.size());
  const auto bound = static_cast<float>(distance_m * distance_m);
  const auto mapped = ParallelSum(0, count, kSamplesPerTask, 0, [&](int begin, int end) {
    int sum = 0;
    std::uint32_t hint = KdTree::kNone;
    for (int i = begin; i < end; ++i) {
      const KdTree::Neighbor found = map.tree.Nearest(reference.tree.Point(i), bound, hint);
      if (found.rank == KdTree::kNone) continue;
      hint = found.rank;
      ++sum;
    }
    return sum;
  });
  return static_cast<double>(mapped) / count;
}

}  // namespace

MapError ComputeMapError(const std::vector<Eigen::Vector3f>& map,
                         const std::vector<Eigen::Vector3f>& reference,
                         const std::vector<Eigen::Vector3f>& reference_normals,
                         const MapErrorOptions& options) {
  Validate(options);
  ThrowIf(!reference_normals.empty() && reference_normals.size() != reference.size(),
          "the reference has ", reference.size(), " points and ", reference_normals.size(),
          " normals, must have one per point or none");
  const Cloud finite_map = Prepare(map, {}, "map");
  const Cloud finite_reference = Prepare(reference, reference_normals, "reference");
  MapError error;
  error.map_points = finite_map.tree.size();
  error.reference_points = finite_reference.tree.size();
  MeasureAccuracy(finite_map, finite_reference, &error);
  error.completeness =
      MeasureCompleteness(finite_reference, finite_map, options.completeness_distance_m);
  return error;
}

MapError ComputeMapErrorOfMesh(const std::vector<Eigen::Vector3f>& map,
                               const std::vector<Eigen::Vector3f>& vertices,
                               const std::vector<Eigen::Vector3i>& triangles,
                               const MapErrorOptions& options) {
  Validate(options);
  const Cloud finite_map = Prepare(map, {}, "map");
  const TriangleTree mesh(vertices, triangles);
  const int count = static_cast<int>(finite_map.tree.size());
  std::vector<double> to_triangle_m(count);
  ParallelFor(0, count, kSamplesPerTask, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      to_triangle_m[i] = mesh.Distance(finite_map.tree.Point(i).cast<double>());
  });
  const double distance_m = options.completeness_distance_m;
  const Cloud surface = Prepare(mesh.Sample(0.5 * distance_m, kMaxSurfaceSamples), {}, "reference");
  MapError error;
  error.map_points = finite_map.tree.size();
  error.reference_points = surface.tree.size();
  error.reference_triangles = mesh.size();
  error.accuracy_m = Summarize(std::move(to_triangle_m));
  error.completeness = MeasureCompleteness(surface, finite_map, distance_m);
  return error;
}

}  // namespace surfit
