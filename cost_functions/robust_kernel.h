#pragma once

#include "cost_functions/lanes.h"

namespace surfit {

// rho(s) of a squared residual s in units of sigma^2, with rho(0) = 0, rho'(0) = 1 and width k in
// sigmas: the cost is 1/2 sum rho(s), and a least-squares step weights its rows by rho'(s).
enum class RobustKernelType {
  kNone,          // s
  kHuber,         // s within k, 2 k sqrt(s) - k^2 beyond
  kTukey,         // k^2/3 (1 - (1 - s/k^2)^3) within k, k^2/3 beyond: far residuals have no say
  kGemanMcClure,  // s / (1 + s/k^2)
  kStudentT,      // k^2 log(1 + s/k^2), of a Student t distribution of scale k
};

struct RobustKernel {
  RobustKernelType type = RobustKernelType::kNone;
  double width = 3;  // k
};

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
