#pragma once

#include <ceres/loss_function.h>

#include "cost_functions/robust_kernel.h"

namespace surfit {

// Robust kernel as a loss function for Ceres. Residuals must be in standard deviations. The second
// derivative is set to 0, because Ceres ignores negative second derivatives.
class KernelLoss final : public ceres::LossFunction {
 public:
  explicit KernelLoss(const RobustKernel& kernel) : kernel_(kernel) {}
  void Evaluate(double s, double rho[3]) const override {
    const KernelValue<double> value = EvaluateKernel(kernel_, s);
    rho[0] = value.rho;
    rho[1] = value.slope;
    rho[2] = 0;
  }

 private:
  RobustKernel kernel_;
};

}  // namespace surfit
