#pragma once

#include <ceres/cost_function.h>

#include <vector>

#include "refinement/motion_prior.h"
#include "refinement/reduced_system.h"

namespace surfit {

// All observations of all surfels, and the prior, as one Ceres residual block over the poses
// (pose.h, on ProductPoseManifold) and the calibration, the displacements eliminated.
//
// The triangular factor R of the reduced hessian, with R^T q = gradient and |q|^2 + e^2 = sum of
// rho, has the cost, the gradient and the Gauss-Newton matrix of all rows, so that
// Levenberg-Marquardt takes the same steps (as ReducedBatch does for one pose). At the best
// displacements the gradient is that of the cost which has them eliminated.
class JointCost final : public ceres::CostFunction {
 public:
  // All three must outlive it.
  JointCost(const SharedSurfels& shared, const MotionPrior& prior, const JointState& initial,
            const RobustKernel& kernel);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  JointState StateOf(double const* const* parameters) const;

  const SharedSurfels& shared_;
  const MotionPrior& prior_;
  const JointState& initial_;  // the image's size
  RobustKernel kernel_;
};

// The calibration as parameter block of kCalibrationSize; the size of the image is left as it is.
void CalibrationToBlock(const DepthCalibration& calibration, double* block);
void CalibrationFromBlock(const double* block, DepthCalibration* calibration);

}  // namespace surfit
