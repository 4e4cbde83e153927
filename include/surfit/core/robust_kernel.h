#pragma once

#include <string>
#include <vector>

namespace surfit {

class OptionVisitor;

// rho(s) of a squared residual s in units of sigma^2, with rho(0) = 0, rho'(0) = 1 and width k in
// sigmas: the cost is 1/2 sum rho(s), and a least-squares step weights its rows by rho'(s).
enum class RobustKernelType {
  kNone,          // s
  kHuber,         // s within k, 2 k sqrt(s) - k^2 beyond
  kTukey,         // k^2/3 (1 - (1 - s/k^2)^3) within k, k^2/3 beyond: far residuals have no say
  kGemanMcClure,  // s / (1 + s/k^2)
  kStudentT,      // k^2 log(1 + s/k^2), of a Student t distribution of scale k
};

// A kernel of that type and width.
struct RobustKernel {
  RobustKernelType type = RobustKernelType::kNone;
  double width = 3;  // k

  void Visit(OptionVisitor& visitor);
};

// "none", "huber", "tukey", "geman_mcclure", "student_t", in this order.
std::vector<std::string> RobustKernelNames();
std::string ToString(RobustKernelType type);

}  // namespace surfit
