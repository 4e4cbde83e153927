#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// A node of a pose graph.
struct PoseGraphPose {
  std::int64_t id = 0;  // its name outside, for files and messages
  Rigid3d world_from_pose;
  bool fixed = false;  // known: never moved
};

// A measurement between two poses. Its error is the left increment (w [rad], v [m]) in the frame of
// a that takes the measured pose to the estimate: log of (world_from_a^-1 world_from_b)
// a_from_b^-1.
struct PoseGraphEdge {
  std::size_t a = 0, b = 0;  // indices of poses
  Rigid3d a_from_b;
  // Of that increment (1/rad^2, 1/m^2), as IcpResult::information is for a = target, b = source;
  // 0 along what was not measured.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  bool loop = false;  // may be wrong; others, the odometry, are trusted
};

// Whether a matrix is finite, symmetric and positive semidefinite, but for rounding to 6 digits as
// in files.
bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix);

// Poses and what was measured between them.
struct PoseGraph {
  std::vector<PoseGraphPose> poses;
  std::vector<PoseGraphEdge> edges;

  // Throws InputError naming the pose or edge if ids are not unique, an edge's poses do not exist
  // or are the same one, numbers are not finite, or IsInformation() does not hold.
  void Validate() const;
};

// (w, v)^T information (w, v) of the edge's error: chi-square distributed with 6 degrees of freedom
// if the information is right.
double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge);

// 1/2 the sum of these.
double Cost(const PoseGraph& graph);

}  // namespace surfit
