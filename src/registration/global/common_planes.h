#pragma once

#include <Eigen/Core>
#include <vector>

#include "registration/global/cloud_fit.h"

namespace surfit {

// Plane of the points x with normal.x = offset_m.
struct CommonPlane {
  Eigen::Vector3f normal;
  float offset_m = 0;

  float DistanceTo(const Eigen::Vector3f& point) const { return normal.dot(point) - offset_m; }
};

// Up to three planes with the most points on the surface of the other cloud, largest first. A point
// is on a plane within `tolerance_m`. Each plane is the tangent plane of a point. The points of a
// plane are removed before the search of the next plane.
std::vector<CommonPlane> FindCommonPlanes(const std::vector<ComparedPoint>& points,
                                          double tolerance_m);

// Number of points on the surface of the other cloud, but on neither of the two largest common
// planes. Two planes leave one direction of motion open, which these points determine.
int CountOffTwoPlanes(const std::vector<ComparedPoint>& points, double tolerance_m);

// Counts of the points off the common planes, by their visibility in the image of the other cloud.
// Three planes determine a pose, and many wrong poses align three planes of a room. Only the
// surfaces off these planes then confirm or refute the pose.
struct StructureCounts {
  int free_space = 0;  // free-space violations
  int visible = 0;     // on the surface or in the free space of the image

  // Ratio of free-space violations. kPriorPoints visible points without violation are added,
  // so that a few points do not decide.
  double ViolationRatio() const { return free_space / (visible + kPriorPoints); }

  static constexpr double kPriorPoints = 20;
};

StructureCounts CountStructure(const std::vector<ComparedPoint>& points, const RangeImage& image,
                               double plane_tolerance_m, double range_tolerance_m);

}  // namespace surfit
