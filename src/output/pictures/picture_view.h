#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "output/pictures/pictures.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// A camera that looks at a map or a cloud for one cell of a picture.
struct PictureView {
  std::string label;
  PinholeCamera camera;
  Rigid3d camera_from_world;
};

// The mean of the cameras' upward (-y) axes in the world, unit length; the first camera's where the
// mean vanishes, and the world's -y where there is no camera.
Eigen::Vector3d UpDirection(const Trajectory& camera_path);

// camera_from_world of a camera at eye that looks along forward, with up upwards in its image.
// forward and up need not be unit length or perpendicular, but must not be parallel.
Rigid3d LookAlong(const Eigen::Vector3d& eye, const Eigen::Vector3d& forward,
                  const Eigen::Vector3d& up);

// A camera of equal focal lengths in whose image of width x height the points fill all but a small
// margin. The farthest 0.5 % on each side may fall outside, points behind the camera are ignored.
PinholeCamera FitCamera(const std::vector<Eigen::Vector3f>& points_in_camera, int width,
                        int height);

// The q quantile of the values, 0 <= q <= 1; `otherwise` where there are none.
float Quantile(std::vector<float> values, double q, float otherwise);

}  // namespace surfit
