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

// Accuracy and completeness of a map, with respect to a reference surface that is given as points.
struct MapError {
  // Distances from each map point to the nearest reference point. They depend on the spacing of the
  // reference: if it is a square grid with spacing s, an exact map has a mean of 0.38 s.
  ErrorStatistics accuracy_m;
  // Absolute distances from each map point to the plane of the nearest reference point. The spacing
  // of the reference has no effect, but errors along the surface are not visible. std::nullopt if
  // the reference has no normals.
  std::optional<ErrorStatistics> plane_accuracy_m;
  // Ratio of complete reference points, in [0, 1].
  double completeness = 0;
  // Number of points with finite coordinates. Other points are ignored.
  std::size_t map_points = 0;
  std::size_t reference_points = 0;
};

// All points are in one frame, in metres: the map is not aligned to the reference.
// `reference_normals` are unit vectors, one per reference point, or empty. The result does not
// depend on the number of threads. Throws InputError for invalid options, and for a cloud without a
// finite point or with more than 2^30 points. Aborts on another number of normals.
MapError ComputeMapError(const std::vector<Eigen::Vector3f>& map,
                         const std::vector<Eigen::Vector3f>& reference,
                         const std::vector<Eigen::Vector3f>& reference_normals,
                         const MapErrorOptions& options);

}  // namespace surfit
