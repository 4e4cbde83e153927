#include "cost_functions/dual.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace surfit::testing {
namespace {

using D2 = Dual<Lanes<double>, 2>;
using Jet = ceres::Jet<double, 2>;

Jet Select(bool condition, const Jet& a, const Jet& b) { return condition ? a : b; }

// Every operation, with numbers that have derivatives (x, y), data without (c) and literals.
template <typename T, typename C>
T AllOperations(const T& x, const T& y, const C& c) {
  using std::sqrt;
  const T sums = x + y + c + 2. - (y - x) - (c - x) - (x - c) - (1. - y) + (c + x) + (3. + x);
  const T products = x * y * c * 2. + 3. * x + c * y;
  const T quotients = x / y + x / c + c / x + 2. / y + y / 4.;
  const T root = sqrt(x * x + y);
  return (-sums) * products + quotients * root + Select(x < y, x * c, y / c) + Select(x > y, x, y) +
         Select(x <= y, y, x) + Select(x >= y, root, x);
}

TEST(Dual, HasTheDerivativesOfJets) {
  const double xs[4] = {0.7, 2.3, 1.1, 0.2}, ys[4] = {1.9, 0.4, 1.1, 3.1},
               cs[4] = {-1.1, 3.7, 0.6, -0.3};
  const D2 lanes = AllOperations(D2::Variable(Lanes<double>::Load(xs), 0),
                                 D2::Variable(Lanes<double>::Load(ys), 1), Lanes<double>::Load(cs));
  for (int k = 0; k < 4; ++k) {
    const Jet jet = AllOperations(Jet(xs[k], 0), Jet(ys[k], 1), cs[k]);
    // A few dozen roundings of numbers below 100.
    EXPECT_NEAR(lanes.value[k], jet.a, 1e-12);
    EXPECT_NEAR(lanes.derivative[0][k], jet.v[0], 1e-12);
    EXPECT_NEAR(lanes.derivative[1][k], jet.v[1], 1e-12);
  }
}

// Whatever the processor has: the numbers are the same bit for bit.
TEST(Instructions, GiveTheSameNumbers) {
  const auto compute = [](auto instructions, float* results) {
    using V = Lanes<float, decltype(instructions)>;
    const float x[8] = {0.1f, -2, 30, 4e-5f, 5, 0.6f, 7.7f, 8.1f};
    Dual<V, 2> a = Dual<V, 2>::Variable(V::Load(x), 0), b(V(0.3));
    for (int i = 0; i < 4; ++i) {
      b = b * a / (b + 1.7) + sqrt(b * b + 0.1) * Select(a > b, a - b, a * 0.01);
    }
    for (int k = 0; k < 8; ++k) {
      results[k] = b.value[k];
      results[8 + k] = b.derivative[0][k];
    }
  };
  float base[16], best[16];
  WithBaseInstructions([&](auto instructions) { compute(instructions, base); });
  WithInstructions([&](auto instructions) { compute(instructions, best); });
  for (int k = 0; k < 16; ++k) EXPECT_EQ(base[k], best[k]) << k;
}

}  // namespace
}  // namespace surfit::testing
