#pragma once

#include "cost_functions/lanes.h"
#include "surfit/core/robust_kernel.h"

namespace surfit {

template <typename V>
struct KernelValue {
  V rho, slope;  // rho(s), rho'(s)
};

// V is a plain number or Lanes.
template <RobustKernelType kType, typename V>
KernelValue<V> EvaluateKernel(const V& s, double width) {
  using std::log;
  using std::sqrt;
  const V one(1.), k2(width * width), share = s / k2;
  if constexpr (kType == RobustKernelType::kNone) {
    return {s, one};
  } else if constexpr (kType == RobustKernelType::kHuber) {
    const auto inside = s <= k2;
    const V root = sqrt(Select(inside, k2, s));  // no division by zero
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

// Calls f(std::integral_constant<RobustKernelType, type>), so that the type is known to the
// compiler.
template <typename F>
auto WithKernelType(RobustKernelType type, const F& f) {
  using T = RobustKernelType;
  switch (type) {
    case T::kHuber:
      return f(std::integral_constant<T, T::kHuber>());
    case T::kTukey:
      return f(std::integral_constant<T, T::kTukey>());
    case T::kGemanMcClure:
      return f(std::integral_constant<T, T::kGemanMcClure>());
    case T::kStudentT:
      return f(std::integral_constant<T, T::kStudentT>());
    case T::kNone:
      break;
  }
  return f(std::integral_constant<T, T::kNone>());
}

}  // namespace surfit
