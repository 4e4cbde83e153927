#pragma once

#include <Eigen/Core>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

enum class AlignmentStatus {
  kAligned,
  // The points lie on a line or in one spot: other rotations fit as well, with the same residuals.
  kRotationNotUnique,
  // Fewer than 3 points; the transform is the identity.
  kTooFewPoints,
};

// A rigid transform between two sets of points.
struct Alignment {
  AlignmentStatus status = AlignmentStatus::kTooFewPoints;
  Rigid3d target_from_source;
};

// The rigid transform, without scale, that minimises sum |target_i - (R source_i + t)|^2 over
// pairs of points in metres (Horn 1987; Umeyama, PAMI 1991, eq. 39-43 with c = 1). R is a proper
// rotation also where a reflection would fit better.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target);

}  // namespace surfit
