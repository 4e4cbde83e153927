#pragma once

#include "surfit/core/lanes.h"

namespace surfit {

// Dual number with N derivatives for automatic differentiation, as ceres::Jet but with SIMD lanes.
// V: Lanes<float> or Lanes<double>. V and scalars are constants, with derivatives of 0. Operations:
// + - * /, sqrt and Select(). Comparisons compare the values only.
template <typename V, int N>
struct Dual {
  V value;
  V derivative[N];

  Dual() = default;
  Dual(const V& v) : value(v) {}  // NOLINT(google-explicit-constructor): a constant
  Dual(double x) : value(x) {}    // NOLINT(google-explicit-constructor): a constant
  static Dual Variable(const V& v, int index) {
    Dual result(v);
    result.derivative[index] = V(1.);
    return result;
  }

  Dual operator-() const { return Chain(-value, V(-1.)); }

  // Dual number of f(value), given f'(value).
  Dual Chain(const V& f, const V& slope) const {
    Dual result(f);
    for (int i = 0; i < N; ++i) result.derivative[i] = slope * derivative[i];
    return result;
  }

  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual result(a.value + b.value);
    for (int i = 0; i < N; ++i) result.derivative[i] = a.derivative[i] + b.derivative[i];
    return result;
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    Dual result(a.value - b.value);
    for (int i = 0; i < N; ++i) result.derivative[i] = a.derivative[i] - b.derivative[i];
    return result;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual result(a.value * b.value);
    for (int i = 0; i < N; ++i) {
      result.derivative[i] = a.value * b.derivative[i] + b.value * a.derivative[i];
    }
    return result;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const V inverse = V(1.) / b.value, quotient = a.value * inverse;
    Dual result(quotient);
    for (int i = 0; i < N; ++i) {
      result.derivative[i] = (a.derivative[i] - quotient * b.derivative[i]) * inverse;
    }
    return result;
  }

  friend Dual operator+(const Dual& a, const V& b) {
    Dual result = a;
    result.value += b;
    return result;
  }
  friend Dual operator+(const V& a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, const V& b) {
    Dual result = a;
    result.value += -b;
    return result;
  }
  friend Dual operator-(const V& a, const Dual& b) { return -b + a; }
  friend Dual operator*(const Dual& a, const V& b) { return a.Chain(a.value * b, b); }
  friend Dual operator*(const V& a, const Dual& b) { return b * a; }
  friend Dual operator/(const Dual& a, const V& b) { return a * (V(1.) / b); }
  friend Dual operator/(const V& a, const Dual& b) {
    const V quotient = a / b.value;
    return b.Chain(quotient, -quotient / b.value);
  }
  friend Dual operator+(const Dual& a, double b) { return a + V(b); }
  friend Dual operator+(double a, const Dual& b) { return b + V(a); }
  friend Dual operator-(const Dual& a, double b) { return a - V(b); }
  friend Dual operator-(double a, const Dual& b) { return V(a) - b; }
  friend Dual operator*(const Dual& a, double b) { return a * V(b); }
  friend Dual operator*(double a, const Dual& b) { return b * V(a); }
  friend Dual operator/(const Dual& a, double b) { return a * V(1 / b); }
  friend Dual operator/(double a, const Dual& b) { return V(a) / b; }

  friend auto operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend auto operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend auto operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend auto operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
};

template <typename V, int N>
Dual<V, N> sqrt(const Dual<V, N>& x) {
  const V root = sqrt(x.value);
  return x.Chain(root, V(0.5) / root);
}

// condition ? a : b per lane, including the derivatives.
template <typename V, int N>
Dual<V, N> Select(const typename V::Mask& condition, const Dual<V, N>& a, const Dual<V, N>& b) {
  Dual<V, N> result(Select(condition, a.value, b.value));
  for (int i = 0; i < N; ++i) {
    result.derivative[i] = Select(condition, a.derivative[i], b.derivative[i]);
  }
  return result;
}

}  // namespace surfit
