#pragma once

#include <Eigen/Core>
#include <optional>

#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Pixel of a point in a colour image, with its derivatives.
struct LensPoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();  // px/m
  Eigen::Vector2d distorted = Eigen::Vector2d::Zero();  // (pixel - centre) / focal length
};

// Projects a point by a camera with lens distortion, with the OpenCV coefficients k1, k2, p1, p2,
// k3. Returns std::nullopt behind the camera, and if the distorted radius does not increase with
// the radius. The image border is not tested.
std::optional<LensPoint> ProjectByLens(const PinholeCamera& camera, const Eigen::Vector3d& point);

// Point at depth 1 that the lens projects to the pixel. Returns std::nullopt if Newton's method
// does not find one.
std::optional<Eigen::Vector3d> RayOfLens(const PinholeCamera& camera, double u, double v);

// True if the pixel is inside the image, at least `margin` px from the centres of the outermost
// pixels.
inline bool IsInside(const PinholeCamera& camera, const Eigen::Vector2d& pixel, double margin) {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= camera.width - 1 - margin &&
         pixel.y() <= camera.height - 1 - margin;
}

// Pinhole camera of the same size and centre with the largest field of view whose border pixels
// have colour. Its focal length is 0.8 to 4 times that of `camera`, and equal without distortion.
PinholeCamera UndistortedCamera(const PinholeCamera& camera);

// Resamples an image of `camera` (at least 2 x 2 px) bilinearly. Pixels that `camera` does not see
// are black.
Image<Rgb8> Undistort(const Image<Rgb8>& image, const PinholeCamera& camera,
                      const PinholeCamera& undistorted);

}  // namespace surfit
