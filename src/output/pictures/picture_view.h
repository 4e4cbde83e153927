#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// View for a picture: a pinhole camera with fx = fy and its pose.
struct PictureView {
  std::string label;
  PinholeCamera camera;
  Rigid3d camera_from_world;
};

// Mean upward (-y) axis of the cameras in the world frame, unit length. If the mean vanishes: axis
// of the first camera. Empty path: -y of the world.
Eigen::Vector3d UpDirection(const Trajectory& camera_path);

// Returns camera_from_world of a camera at `eye` that looks along `forward`. `up` is upwards in the
// image. `forward` and `up` need no unit length, but must not be parallel.
Rigid3d LookAlong(const Eigen::Vector3d& eye, const Eigen::Vector3d& forward,
                  const Eigen::Vector3d& up);

// Camera with fx = fy whose image the points fill in width or height, except for a small margin. On
// each side, 0.5 % of the points may be outside. Ignores points behind the camera. Without points:
// a field of view of 56 degrees along the shorter side.
PinholeCamera FitCamera(const std::vector<Eigen::Vector3f>& points_in_camera, int width,
                        int height);

// q-quantile (nearest rank) of the values, 0 <= q <= 1; `otherwise` if there are no values. The
// values must not be NaN.
float Quantile(std::vector<float> values, double q, float otherwise);

}  // namespace surfit
