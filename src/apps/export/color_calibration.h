#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "apps/export/color_images.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Parameters of EstimateColorCamera(): left increment of color_from_depth (rad, m), relative
// changes of fx and fy, changes of cx and cy (px), colour latency (s).
inline constexpr int kColorParameters = 11;
using ColorParameters = Eigen::Matrix<double, kColorParameters, 1>;

struct ColorCalibration {
  ColorCamera camera;         // the given camera if the estimate is not significant
  double latency_s = 0;       // to be subtracted from the capture times, s
  bool is_estimated = false;  // false: the given camera is kept
  int images = 0;             // images used; 0: too few images or surfels
  std::size_t observations = 0;
  ColorParameters change = ColorParameters::Zero();  // estimate minus given camera
  ColorParameters sigmas = ColorParameters::Zero();  // standard deviations
  double distance2 = 0, limit2 = 0;  // squared Mahalanobis distance of the change, and its limit
  // Root mean square difference of log brightness between images, before and after.
  double rms_before = 0, rms_after = 0;
};

// Estimates the colour camera of a run from the map and at most 120 of the images. Estimates
// color_from_depth, focal lengths, principal point and latency. Lens distortion is fixed.
//
// A surfel k with the position X_k has the same log brightness in all images i that show it, except
// for an exposure. So the images, high-pass filtered, satisfy
//   B_i(pi(C D_i X_k)) = b_k
// with the transform D_i from the world to the depth camera, and color_from_depth C. The mean b_k
// is eliminated: residuals and derivatives are centred per surfel. Gauss-Newton with the kernel of
// Geman and McClure, from coarse to fine images. A point moves during the readout as in
// RegisterColors(). The covariance is computed from the scatter of the gradients over the images
// (sandwich estimator, Huber 1967). The estimate is used if distance2 exceeds limit2 (mean plus
// three standard deviations of chi-square) and rms_after is below rms_before.
//
// Keeps the given camera for fewer than ten images, fewer than 500 surfels in at least four images,
// or a step without solution. `progress` must not be empty. It receives the number of images read
// so far. Throws InputError if an image cannot be read.
ColorCalibration EstimateColorCamera(const ColorCamera& given, const CalibrationPrior& prior,
                                     const SequenceOptions& sequence,
                                     const std::vector<ColorImage>& images, const SurfelMap& map,
                                     const std::function<void(int)>& progress);

}  // namespace surfit
