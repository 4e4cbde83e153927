#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "surfit/evaluation/error_statistics.h"

namespace surfit {

class OptionVisitor;

// Options of ComputeMapError().
struct MapErrorOptions {
  // A reference point is complete if a map point is at most this far away. Must be positive.
  double completeness_distance_m = 0.01;

  void Visit(OptionVisitor& visitor);
};

// Accuracy and completeness of a map, relative to a reference surface.
struct MapError {
  // Distances from each map point to the nearest triangle of a reference mesh, or to the nearest
  // point of a reference cloud. Distances to points depend on the point spacing s of the
  // reference: on a square grid, an exact map has a mean of 0.38 s.
  ErrorStatistics accuracy_m;
  // Distances from each map point to the tangent plane of the nearest reference point.
  // Independent of the point spacing, but blind to errors along the surface. std::nullopt
  // without reference normals, and for a mesh.
  std::optional<ErrorStatistics> plane_accuracy_m;
  // Ratio of complete reference points, in [0, 1].
  double completeness = 0;
  // Number of points with finite coordinates. Other points are ignored.
  std::size_t map_points = 0;
  // For a mesh, the number of samples of its surface, with equal area per sample.
  std::size_t reference_points = 0;
  // Triangles of a mesh with finite vertices. 0 for a cloud.
  std::size_t reference_triangles = 0;
};

// Computes the errors of a map. Both clouds are in the same frame, in metres: the map is not
// aligned. `reference_normals`: one finite unit vector per reference point, or empty. Runs on all
// worker threads; the result does not depend on their number. Throws InputError for invalid
// options, and for a cloud without finite points or with more than 2^30 points. Throws if the
// number of normals is wrong.
MapError ComputeMapError(const std::vector<Eigen::Vector3f>& map,
                         const std::vector<Eigen::Vector3f>& reference,
                         const std::vector<Eigen::Vector3f>& reference_normals,
                         const MapErrorOptions& options);

// Computes the errors relative to a mesh. `triangles`: indices of `vertices`, three per triangle.
// Completeness is the ratio of the area: the surface is sampled at half of the completeness
// distance, with at most 4 million points. Throws InputError like ComputeMapError(), and for an
// invalid index or a mesh without area.
MapError ComputeMapErrorOfMesh(const std::vector<Eigen::Vector3f>& map,
                               const std::vector<Eigen::Vector3f>& vertices,
                               const std::vector<Eigen::Vector3i>& triangles,
                               const MapErrorOptions& options);

}  // namespace surfit
