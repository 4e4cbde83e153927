#include "refinement/joint_covariance.h"

namespace surfit {

JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& held_calibration) {
  // Rounding leaves about as much of the zeros of a singular hessian whose diagonal is of ones;
  // should it leave more, a larger damping factorises.
  constexpr double kLeastPivot = 1e-12, kGrowth = 10;
  ReducedFactor factor(*system.pattern, held_calibration);
  double damping = kLeastPivot;
  while (damping < 1 && !factor.Factorize(system, damping)) damping *= kGrowth;
  return factor.Covariance();
}

}  // namespace surfit
