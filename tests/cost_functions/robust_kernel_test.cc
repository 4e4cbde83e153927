#include "cost_functions/robust_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace surfit::testing {
namespace {

constexpr RobustKernelType kAll[] = {RobustKernelType::kNone, RobustKernelType::kHuber,
                                     RobustKernelType::kTukey, RobustKernelType::kGemanMcClure,
                                     RobustKernelType::kStudentT};

template <typename V>
KernelValue<V> Evaluate(RobustKernelType type, const V& s, double width) {
  return EvaluateKernel({type, width}, s);
}

TEST(RobustKernel, IsSquareAtZero) {
  for (const auto type : kAll) {
    const KernelValue<double> at_zero = Evaluate(type, 0., 2);
    EXPECT_EQ(at_zero.rho, 0);
    EXPECT_EQ(at_zero.slope, 1);
  }
}

TEST(RobustKernel, SlopeIsDerivativeAndCostIsConcave) {
  constexpr double kStep = 1e-5;
  for (const auto type : kAll) {
    for (const double s : {0.1, 1., 3.9, 4.1, 10., 100.}) {
      const KernelValue<double> value = Evaluate(type, s, 2);
      const double difference =
          (Evaluate(type, s + kStep, 2).rho - Evaluate(type, s - kStep, 2).rho);
      // The third derivatives are below 1, times the squared step. The rounding of 100 is divided
      // by the step.
      EXPECT_NEAR(value.slope, difference / (2 * kStep), 1e-8) << s;
      EXPECT_GE(value.rho, s * value.slope - 1e-12) << s;
    }
  }
}

TEST(RobustKernel, AgreesWithKnownValues) {
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kHuber, 16., 2).rho, 2 * 2 * 4 - 4);
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kHuber, 16., 2).slope, 0.5);
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kTukey, 2., 2).rho, 4. / 3 * (1 - 1. / 8));
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kTukey, 5., 2).slope, 0);
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kGemanMcClure, 4., 2).rho, 2);
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kGemanMcClure, 4., 2).slope, 0.25);
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kStudentT, 4., 2).rho, 4 * std::log(2.));
  EXPECT_DOUBLE_EQ(Evaluate(RobustKernelType::kStudentT, 4., 2).slope, 0.5);
}

TEST(RobustKernel, LanesAgreeWithScalars) {
  const double s[4] = {0, 3.9, 4.1, 50};
  for (const auto type : kAll) {
    const auto lanes = Evaluate(type, Lanes<double>::Load(s), 2);
    for (int k = 0; k < 4; ++k) {
      EXPECT_DOUBLE_EQ(lanes.rho[k], Evaluate(type, s[k], 2).rho);
      EXPECT_DOUBLE_EQ(lanes.slope[k], Evaluate(type, s[k], 2).slope);
    }
  }
}

}  // namespace
}  // namespace surfit::testing
