#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace surfit {

// A pinhole camera: u = fx x/z + cx, v = fy y/z + cy; x right, y down, z forward; the centre of
// the first pixel is (0, 0). Lens distortion follows OpenCV's k1 k2 p1 p2 k3; Project() and Ray()
// ignore it: they serve images that have been undistorted.
struct PinholeCamera {
  int width = 0;   // px
  int height = 0;  // px
  double fx = 0;   // px
  double fy = 0;   // px; negative in files whose image y axis points up
  double cx = 0;   // px
  double cy = 0;   // px
  std::array<double, 5> distortion = {0, 0, 0, 0, 0};

  bool HasDistortion() const;

  // Throws InputError naming `what`, the field, its value and the constraint.
  void Validate(const std::string& what) const;

  // Pixel coordinates (u, v) of a point with z > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_camera) const {
    return {fx * point_in_camera.x() / point_in_camera.z() + cx,
            fy * point_in_camera.y() / point_in_camera.z() + cy};
  }
  // The point at depth z = 1 that projects to (u, v).
  Eigen::Vector3d Ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }

  // The camera of an image that keeps every factor-th pixel, starting with the first: the size is
  // rounded up; focal length and principal point are divided (pixel centres are integers).
  PinholeCamera Subsampled(int factor) const;
  // The camera of an image whose pixels are means of factor x factor blocks; the size is rounded
  // down, and the block's centre is its pixel's centre.
  PinholeCamera Binned(int factor) const;
};

}  // namespace surfit
