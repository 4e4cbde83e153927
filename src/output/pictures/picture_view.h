#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "output/pictures/pictures.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Camera of a picture cell that shows a map or a cloud.
struct PictureView {
  std::string label;
  PinholeCamera camera;
  Rigid3d camera_from_world;
};

// Unit vector of the mean upward (-y) axis of the cameras in the world frame. If the mean vanishes:
// the axis of the first camera. For an empty path: -y of the world.
Eigen::Vector3d UpDirection(const Trajectory& camera_path);

// camera_from_world of a camera at `eye` that looks along `forward`, with `up` upwards in its
// image. `forward` and `up` must not be parallel; they may have any length.
Rigid3d LookAlong(const Eigen::Vector3d& eye, const Eigen::Vector3d& forward,
                  const Eigen::Vector3d& up);

// Camera with fx = fy whose image of width x height px is filled by the points except for a small
// margin. On each side, 0.5 % of the points may be outside. Points behind the camera are ignored.
PinholeCamera FitCamera(const std::vector<Eigen::Vector3f>& points_in_camera, int width,
                        int height);

// q quantile of the values, 0 <= q <= 1; `otherwise` without values.
float Quantile(std::vector<float> values, double q, float otherwise);

}  // namespace surfit
