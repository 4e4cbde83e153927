#pragma once

#include "registration/icp/view_level.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// A point farther in front of a surface than so many sigmas contradicts it.
inline constexpr double kFreeSpaceSigmas = 5;

// How far the source contradicts the target at a pose: a source point p' in front of the surface
// (vertex q, normal n facing the camera) at the target pixel it projects to fills space that the
// target camera saw through. Returns the share of points with r > kFreeSpaceSigmas * sigma among
// those with r >= -kFreeSpaceSigmas * sigma,
//   r = n . (p' - q),  sigma^2 = floor_sigma_m^2 + sigma_z(p'_z)^2 + sigma_z(q_z)^2.
// Points behind may be hidden and say nothing, nor do pixels without a normal (missing depth, depth
// edges); 0 where no point says anything. Two views of a rigid scene hardly contradict each other
// at the true pose, while a fit of some surfaces to others leaves the rest in each other's free
// space.
double FreeSpaceShare(const FrameLevel& source, const FrameLevel& target,
                      const ErrorModel& error_model, const Rigid3d& target_from_source);

// Sums that the correlation of two images follows from.
struct CorrelationSums {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void Add(double value_a, double value_b);
  // From -1 to 1; near 0 where an image is even: `floor_variance` is added to both variances.
  double Correlation(double floor_variance) const;
};

// How well two views agree at a pose: the correlations are means of both ways.
struct ViewFit {
  double overlap_share = 0;       // of all points, those that lie on the other view's surface
  double free_space_share = 0;    // the larger share of telling points in the other's free space
  double value_correlation = 0;   // of the brightness where the surfaces lie on each other
  double detail_correlation = 0;  // and of its detail

  // The larger, the better: the square root of the overlap, times what the images tell of each
  // other in nats per pixel (for normally distributed values, -log(1 - rho^2) / 2) and a constant
  // for the shapes, less where free space is filled. The root, as sliding along what the shapes
  // leave open often adds overlap where hardly anything tells.
  double Score() const;
};

// Surfaces lie on each other where the distance is within kFreeSpaceSigmas of the error model and
// the normals agree. Of both views every n-th column and row is taken.
ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source, int stride = 1);

}  // namespace surfit
