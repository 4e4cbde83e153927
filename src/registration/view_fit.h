#pragma once

#include "registration/view_level.h"
#include "surfit/registration/error_model.h"

namespace surfit {

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
// the normals agree.
ViewFit MeasureFit(const ViewLevel& source, const ViewLevel& target, const ErrorModel& error_model,
                   const Rigid3d& target_from_source);

}  // namespace surfit
