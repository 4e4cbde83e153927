#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace surfit {

// Pinhole camera: u = fx x/z + cx, v = fy y/z + cy. Camera axes: x right, y down (up if fy < 0), z
// forward. The centre of the top-left pixel is (0, 0). Lens distortion uses the model of OpenCV.
// Project() and Ray() ignore the distortion and apply to undistorted images.
struct PinholeCamera {
  int width = 0;   // px
  int height = 0;  // px
  double fx = 0;   // px
  double fy = 0;   // px; negative if the y axis of the camera points up
  double cx = 0;   // px
  double cy = 0;   // px
  std::array<double, 5> distortion = {0, 0, 0, 0, 0};  // k1, k2, p1, p2, k3

  bool HasDistortion() const;

  // Throws InputError with the name `what`, the field, its value and the constraint. Sizes must be
  // 1 to 16384 px, fx positive, fy not 0, and all numbers finite.
  void Validate(const std::string& what) const;

  // Pixel coordinates (u, v) of a point in m with z > 0. The point may be outside the image.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_camera) const {
    return {fx * point_in_camera.x() / point_in_camera.z() + cx,
            fy * point_in_camera.y() / point_in_camera.z() + cy};
  }
  // Point at depth z = 1 that projects to the pixel coordinates (u, v).
  Eigen::Vector3d Ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }

  // Camera of an image with every `factor`-th column and row, beginning with index 0. Rounds the
  // size up. Requires factor >= 1.
  PinholeCamera Subsampled(int factor) const;
  // Camera of an image whose pixels are means of `factor` x `factor` pixels. Rounds the size down.
  // Requires factor >= 1.
  PinholeCamera Binned(int factor) const;
};

}  // namespace surfit
