#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "apps/export/color_images.h"
#include "apps/export/sparse_points.h"
#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Calls the second argument with the position and the colour of each image, in ascending order.
using ColorReader = std::function<void(
    const std::vector<ColorImage>&, const std::function<void(std::size_t, const Image<Rgb8>&)>&)>;

// Result of RegisterImages(). Images of the first three counts keep their poses.
struct ImageRegistration {
  int too_few_surfels = 0;               // images with fewer than 200 surfels
  int contradicting = 0;                 // images whose result contradicts the tracked pose
  int without_gain = 0;                  // images whose residuals do not decrease enough
  int registered = 0;                    // images with a new pose
  double median_change_m = 0;            // of the camera centres of registered images, m
  double median_change_rad = 0;          // rotation angle of registered images, rad
  double rms_before = 0, rms_after = 0;  // robust RMS residual of the log brightness
};

// Registers images to each other by the brightness of surfels, and replaces their poses. This
// corrects the errors of single poses of the tracker.
//
// The high-pass filtered log brightness b_k of the surfel k is equal in all images that show the
// surfel. Each image minimises over its pose
//   sum_k rho(B(pi(X_k)) - b_k) / (25 s^2) + |rotation / 5 mrad|^2 + |translation / 2 mm|^2
// with the brightness B of the image at the projection of the surfel, the kernel rho of Geman and
// McClure, and the RMS residual s. 25 is the number of neighbouring surfels with fully correlated
// errors. Rotation and translation are the change of the tracked pose. Their standard deviations
// are the errors of tracked poses. b_k is the robust mean over the images. Poses and means
// alternate, from coarse to fine images. With a rolling shutter, the pose is that of the middle
// row.
//
// An image keeps its pose in three cases:
// - Fewer than 200 of its surfels are visible in four images.
// - The squared change in standard deviations exceeds 38, the chi-square limit of 1e-6.
// - The residuals of the image do not decrease, or the RMS residual of all images decreases by less
//   than 5 %. Then the tracked poses are nearly exact.
//
// `camera`: final colour camera. `progress` receives the number of images so far, and must not be
// empty. More than 300 images are registered in interleaved groups, which bounds the memory. The
// result is bitwise identical for any number of threads.
ImageRegistration RegisterImages(const ColorCamera& camera, const SurfelMap& map,
                                 const ColorReader& read, const std::function<void(int)>& progress,
                                 std::vector<PosedImage>* images);

// Motion of the colour camera in its own frame, from the motion of the depth camera.
CameraMotion MotionOfColorCamera(const CameraMotion& motion, const Rigid3d& color_from_depth);

}  // namespace surfit
