#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "surfit/evaluation/error_statistics.h"

namespace surfit {

class OptionVisitor;

// How a map is compared with its reference.
struct MapErrorOptions {
  // A reference point counts as mapped if a map point is at most this far.
  double completeness_distance_m = 0.01;

  void Visit(OptionVisitor& visitor);
};

// How near a map is to a reference surface that is given as points, and how much of it it holds.
struct MapError {
  // From each map point to the nearest reference point. The reference's own spacing s is part of
  // it: a perfect map of a square grid still has a mean of 0.38 s.
  ErrorStatistics accuracy_m;
  // The same to the plane of the nearest reference point, if the reference has normals: without
  // the reference's spacing, but blind to errors along the surface.
  std::optional<ErrorStatistics> plane_accuracy_m;
  // Share of the reference points that have a map point within completeness_distance_m.
  double completeness = 0;
  // Points with finite coordinates; others are left out.
  std::size_t map_points = 0;
  std::size_t reference_points = 0;
};

// All points in one frame, metres. reference_normals are unit vectors, or none at all.
// Throws InputError if the options are not valid, or if a cloud has no finite point.
MapError ComputeMapError(const std::vector<Eigen::Vector3f>& map,
                         const std::vector<Eigen::Vector3f>& reference,
                         const std::vector<Eigen::Vector3f>& reference_normals,
                         const MapErrorOptions& options);

}  // namespace surfit
