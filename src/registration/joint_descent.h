#pragma once

#include "registration/view_level.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// How a pose descends on one pyramid level.
struct DescentOptions {
  int max_steps = 10;
  double max_distance_m = 0.4;      // points farther apart are no pairs; shrinks by 0.85 a step ...
  double max_distance_end_m = 0.2;  // ... down to this
  bool use_brightness = true;
  bool rotation_only = false;
  double damping = 3e-3;  // of a direction that the pairs do not hold, as a share of one they do
};

// The normal equations of both residuals of the pairs at a pose.
struct JointSystem {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
  double weight = 0;               // sum of the weights of the point-to-plane residuals
  double weighted_square_sum = 0;  // sum of these weights times |p'|^2
  int pair_count = 0;

  // Measuring rotations as arc lengths at this distance, metres.
  double RmsDistance() const;
};

// For each pair of points that land on each other, p' = R p + t with the surface (q, n) and the
// target's brightness I at its pixel: the point-to-plane residual n . (p' - q), row [p' x n, n],
// and the brightness residual I(p') - (a J + b), row [p' x d, d] with d = dI/dp'. J is the source's
// brightness, a and b match the means and standard deviations of both (exposure). Both residuals
// have a Geman-McClure kernel.
JointSystem LinearizeJointly(const ViewLevel& source, const ViewLevel& target,
                             double max_distance_m, bool use_brightness,
                             const Rigid3d& target_from_source);

// Gauss-Newton steps from a start.
Rigid3d Descend(const ViewLevel& source, const ViewLevel& target, const Rigid3d& start,
                const DescentOptions& options);

}  // namespace surfit
