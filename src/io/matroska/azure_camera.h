#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "io/images/image_files.h"
#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Lens of an Azure Kinect camera: OpenCV's rational model about the centre of distortion. With
// (x, y) relative to this centre and r2 = x^2 + y^2, the distorted ray is
//   x d + p2 (r2 + 2 x^2) + t p1 x y,  d = (1 + k1 r2 + k2 r2^2 + k3 r2^3) /
//   y d + p1 (r2 + 2 y^2) + t p2 x y       (1 + k4 r2 + k5 r2^2 + k6 r2^3)
// and t = 2. Early devices have t = 1 (the model Rational6KT).
struct AzureLens {
  std::array<double, 6> k = {0, 0, 0, 0, 0, 0};
  double p1 = 0, p2 = 0, t = 2;
  Eigen::Vector2d centre = {0, 0};
  double max_radius = 1.7;  // the model is valid below this r

  // Distorted ray (x / z, y / z). std::nullopt beyond `max_radius`.
  std::optional<Eigen::Vector2d> Distorted(const Eigen::Vector2d& ray) const;
};

// Camera of the images as recorded. `pinhole` has no distortion.
struct AzureCamera {
  PinholeCamera pinhole;
  AzureLens lens;
};

// Cameras of calibration.json, for the image sizes of a recording.
struct AzureCalibration {
  AzureCamera depth;
  std::optional<AzureCamera> color;
  Rigid3d color_from_depth;  // m; identity without colour
};

// Parses calibration.json. Its intrinsics are relative to the size of the sensor, which the modes
// of the cameras crop and bin. `color` of 0 x 0: no colour. Throws InputError with `what`, the key
// and the constraint. The size of depth images must be that of a mode.
AzureCalibration ParseAzureCalibration(const std::string& json, ImageSize depth, ImageSize color,
                                       const std::string& what);

// Removes the lens distortion of images. Memory for images is allocated by the first call of
// Undistorted(). Not thread-safe.
class AzureUndistorter {
 public:
  explicit AzureUndistorter(const AzureCamera& camera);

  // Camera of the results. Focal lengths are those of the recorded images. The image contains the
  // middle of each border of the recorded images, and is at most twice as large.
  const PinholeCamera& pinhole() const { return pinhole_; }

  // Nearest pixel; 0 outside the recorded image. The image must have the size of the camera.
  Image<std::uint16_t> Undistorted(const Image<std::uint16_t>& depth);
  // Bilinear interpolation; black outside the recorded image.
  Image<Rgb8> Undistorted(const Image<Rgb8>& color);

 private:
  void FindPixels();

  AzureCamera camera_;
  PinholeCamera pinhole_;
  Image<float> u_, v_;  // recorded pixel of each pixel; NaN: outside
};

}  // namespace surfit
