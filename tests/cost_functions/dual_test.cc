#include "cost_functions/dual.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace surfit {
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
  const double xs[2] = {0.7, 2.3}, ys[2] = {1.9, 0.4}, cs[2] = {-1.1, 3.7};
  const D2 lanes = AllOperations(D2::Variable(Lanes<double>::Load(xs), 0),
                                 D2::Variable(Lanes<double>::Load(ys), 1), Lanes<double>::Load(cs));
  for (int k = 0; k < 2; ++k) {
    const Jet jet = AllOperations(Jet(xs[k], 0), Jet(ys[k], 1), cs[k]);
    // A few dozen roundings of numbers below 100.
    EXPECT_NEAR(lanes.value[k], jet.a, 1e-12);
    EXPECT_NEAR(lanes.derivative[0][k], jet.v[0], 1e-12);
    EXPECT_NEAR(lanes.derivative[1][k], jet.v[1], 1e-12);
  }
}

TEST(Lanes, AreFourFloatsOrTwoDoubles) {
  EXPECT_EQ(Lanes<float>::kCount, 4);
  EXPECT_EQ(Lanes<double>::kCount, 2);
  const float x[4] = {1, 2, 3, 4};
  const Lanes<float> y = Lanes<float>::Load(x) * 2. + 1.;
  for (int k = 0; k < 4; ++k) EXPECT_EQ(y[k], 2 * x[k] + 1);
}

}  // namespace
}  // namespace surfit
