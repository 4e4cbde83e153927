#pragma once

#include "surfit/core/lanes.h"
#include "surfit/core/robust_kernel.h"

namespace surfit {

// Value and derivative of a robust kernel.
template <typename V>
struct KernelValue {
  V rho, slope;  // rho(s), rho'(s)
};

// V: scalar or Lanes. s: squared residual in units of sigma^2. The width must be positive; it has
// no effect for kNone.
template <RobustKernelType kType, typename V>
KernelValue<V> EvaluateKernel(const V& s, double width) {
  using std::log;
  using std::sqrt;
  const V one(1.), k2(width * width), share = s / k2;
  if constexpr (kType == RobustKernelType::kNone) {
    return {s, one};
  } else if constexpr (kType == RobustKernelType::kHuber) {
    const auto inside = s <= k2;
    const V root = sqrt(Select(inside, k2, s));  // avoids a division by zero
    return {Select(inside, s, V(2. * width) * root - k2), V(width) / root};
  } else if constexpr (kType == RobustKernelType::kTukey) {
    const V rest = Select(share < one, one - share, V(0.));
    return {k2 / V(3.) * (one - rest * rest * rest), rest * rest};
  } else if constexpr (kType == RobustKernelType::kGemanMcClure) {
    const V damping = one / (one + share);
    return {s * damping, damping * damping};
  } else {
    return {k2 * log(one + share), one / (one + share)};
  }
}

// Selects the kernel type at run time.
template <typename V>
KernelValue<V> EvaluateKernel(const RobustKernel& kernel, const V& s) {
  switch (kernel.type) {
    case RobustKernelType::kHuber:
      return EvaluateKernel<RobustKernelType::kHuber>(s, kernel.width);
    case RobustKernelType::kTukey:
      return EvaluateKernel<RobustKernelType::kTukey>(s, kernel.width);
    case RobustKernelType::kGemanMcClure:
      return EvaluateKernel<RobustKernelType::kGemanMcClure>(s, kernel.width);
    case RobustKernelType::kStudentT:
      return EvaluateKernel<RobustKernelType::kStudentT>(s, kernel.width);
    case RobustKernelType::kNone:
      break;
  }
  return EvaluateKernel<RobustKernelType::kNone>(s, kernel.width);
}

}  // namespace surfit
