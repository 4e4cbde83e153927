#pragma once

#include <vector>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Image corner of an earlier frame, tracked to the present frame.
struct TrackedCorner {
  Eigen::Vector3d point;      // in the earlier camera, m
  Eigen::Vector2d first;      // in the earlier frame, px
  Eigen::Vector2d seen;       // in the present frame, px
  bool moved_before = false;  // on a moving object of the earlier frame
};

// Rigid motion of the static scene in the image, and the corners that contradict it.
struct CornerMotion {
  enum class Label { kUnknown, kStatic, kMoving };

  Rigid3d now_from_before;
  std::vector<Label> labels;  // per corner; empty: no motion has enough support
  // The motion has large support, and enough corners agree on a second motion, by the rule of
  // FeatureMotion::HasTwoMotions().
  bool is_certain = false;
};

// Estimates the rigid motion with the largest support in the image: RANSAC (Fischler and Bolles
// 1981) over reprojection errors. Each block of the image has the same weight, because a textured
// shirt has more corners than a wall. A second motion of the background takes precedence over a
// nearer motion with less than twice its support. `expected`: an initial pose.
CornerMotion FindStaticMotion(const std::vector<TrackedCorner>& corners,
                              const PinholeCamera& camera, const Rigid3d& expected);

// Returns true if more than half of the static corners, by weight, are clearly apart from their
// places at this pose. `motion`: result of FindStaticMotion() for these corners.
bool ContradictsStaticCorners(const std::vector<TrackedCorner>& corners, const CornerMotion& motion,
                              const PinholeCamera& camera, const Rigid3d& now_from_before);

}  // namespace surfit
