#pragma once

#include <string>
#include <vector>

namespace surfit {

class OptionVisitor;

// Robust kernel rho(s) of the squared residual s in units of sigma^2, with the width k in sigmas.
// rho(0) = 0 and rho'(0) = 1. The cost is 1/2 sum rho(s). Iteratively reweighted least squares uses
// the weights rho'(s).
enum class RobustKernelType {
  kNone,          // s
  kHuber,         // s if s <= k^2, else 2 k sqrt(s) - k^2
  kTukey,         // k^2/3 (1 - (1 - s/k^2)^3) if s < k^2, else k^2/3: weight 0
  kGemanMcClure,  // s / (1 + s/k^2)
  kStudentT,      // k^2 log(1 + s/k^2), the Cauchy kernel
};

// Type and width of a robust kernel.
struct RobustKernel {
  RobustKernelType type = RobustKernelType::kNone;
  double width = 3;  // k in sigmas, positive; no effect for kNone

  void Visit(OptionVisitor& visitor);
};

// "none", "huber", "tukey", "geman_mcclure", "student_t".
std::vector<std::string> RobustKernelNames();
std::string ToString(RobustKernelType type);  // "unknown" for other values

}  // namespace surfit
