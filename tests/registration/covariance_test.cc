#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

// Monte Carlo: targets off by normal noise along known normals. The normalised squared error
// (NEES) of the poses is then chi-square distributed with six degrees of freedom; its mean over
// N trials is chi-square of 6 N degrees over N, whose 99.9 % interval is 6 +- 3.29 sqrt(12 / N) to
// within a percent of that width.
TEST(CovarianceOf, IsConsistentWithTheErrorsOfManyTrials) {
  constexpr int kTrials = 1000, kPairs = 300;
  constexpr double kSigma = 0.01;
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  PoseSolverOptions options;
  options.error_model.kernel.type = RobustKernelType::kNone;
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(options);
  double with_known_sigma = 0, with_estimated_sigma = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Correspondences exact = testing::ExactCorrespondences(kPairs, Rigid3d(), &rng);
    Correspondences pairs;
    for (int i = 0; i < kPairs; ++i) {
      pairs.Add(exact.p(i), exact.q(i) + kSigma * normal(rng) * exact.n(i), exact.n(i), exact.m(i),
                1 / (kSigma * kSigma));
    }
    // The first step's remainder is of the square of its 1e-3: a second one leaves 1e-9.
    const Vector6d first = solver->Step(pairs).increment;
    const Correspondences moved = Moved(pairs, LeftIncrement<double>(first, Rigid3d()));
    const StepResult step = solver->Step(moved);
    const Vector6d error = first + step.increment;
    with_known_sigma += error.dot(step.system.hessian * error);
    with_estimated_sigma += error.dot(CovarianceOf(step.system).ldlt().solve(error));
  }
  const double half_width = 3.29 * std::sqrt(12.0 / kTrials);
  EXPECT_NEAR(with_known_sigma / kTrials, 6, half_width);
  // An estimated variance makes it an F distribution: its mean is larger by f / (f - 2),
  // f = 294 degrees of freedom, and its spread by a little.
  const double f = kPairs - 6;
  EXPECT_NEAR(with_estimated_sigma / kTrials, 6 * f / (f - 2), 1.02 * half_width);
}

}  // namespace
}  // namespace surfit
