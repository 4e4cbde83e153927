#include "surfit/registration/normal_system.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "registration/global/register_from.h"
#include "registration/icp/icp_level.h"
#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"

namespace surfit::testing {

namespace {

const ObservabilityOptions kHeld = {1e-6, 0};

NormalSystem PointToPlaneSystem(const Correspondences& pairs) {
  return Linearize(pairs, ResidualType::kPointToPlane, {});
}

TEST(NormalSystem, SumAgreesWithSystemOfAllPairs) {
  std::mt19937_64 rng(4);
  Correspondences all;
  NormalSystem sum;
  for (int part = 0; part < 3; ++part) {
    const Correspondences pairs = RandomCorrespondences(50, 1, &rng);
    sum += PointToPlaneSystem(pairs);
    for (int i = 0; i < pairs.size; ++i) {
      all.Add(pairs.p(i), pairs.q(i), pairs.n(i), pairs.m(i), pairs.information[i]);
    }
  }
  const NormalSystem expected = PointToPlaneSystem(all);
  EXPECT_THAT(sum.hessian, VectorNear(expected.hessian, 1e-14 * expected.hessian.norm()));
  EXPECT_THAT(sum.right_side, VectorNear(expected.right_side, 1e-12));
  EXPECT_NEAR(sum.cost, expected.cost, 1e-12);
  EXPECT_NEAR(sum.weighted_square_sum, expected.weighted_square_sum, 1e-12);
  EXPECT_NEAR(sum.normal_difference_sum, expected.normal_difference_sum, 1e-12);
  EXPECT_THAT(sum.point_sum, VectorNear(expected.point_sum, 1e-10));
  EXPECT_THAT(sum.point_product_sum, VectorNear(expected.point_product_sum, 1e-10));
  EXPECT_EQ(sum.row_count, expected.row_count);
  EXPECT_EQ(sum.pair_count, expected.pair_count);
  EXPECT_EQ(sum.inlier_count, expected.inlier_count);
  EXPECT_GT(sum.inlier_count, 0);
}

TEST(NormalSystem, AverageLossIsWeightedMeanOfSquares) {
  Correspondences pairs;
  pairs.Add({0, 0, 2}, {0, 0, 2.1}, {0, 0, -1}, {0, 0, -1}, 1);  // r = 0.1
  pairs.Add({0, 0, 2}, {0, 1, 2.3}, {0, 0, -1}, {0, 0, -1}, 3);  // r = 0.3
  EXPECT_NEAR(PointToPlaneSystem(pairs).AverageLoss(), (0.01 + 3 * 0.09) / 4, 1e-15);
}

TEST(NormalSystem, RmsDistanceIsDistanceOfMovedPoints) {
  Correspondences pairs;
  pairs.Add({0, 3, 4}, {0, 0, 1}, {0, 0, -1}, {0, 0, -1}, 1);  // 5 m
  pairs.Add({0, 0, 1}, {0, 0, 1}, {0, 0, -1}, {0, 0, -1}, 3);  // 1 m
  EXPECT_NEAR(PointToPlaneSystem(pairs).RmsDistance(), std::sqrt((25.0 + 3 * 1) / 4), 1e-15);
}

TEST(Observe, EigenvaluesAreIndependentOfUnitsAndWeights) {
  std::mt19937_64 rng(5);
  const Correspondences pairs = RandomCorrespondences(200, 0.1, &rng);
  Correspondences scaled;
  for (int i = 0; i < pairs.size; ++i) {
    scaled.Add(100 * pairs.p(i), 100 * pairs.q(i), pairs.n(i), pairs.m(i),
               7 * pairs.information[i]);
  }
  const Vector6d eigenvalues = Observe(PointToPlaneSystem(pairs), kHeld).eigenvalues;
  EXPECT_THAT(Observe(PointToPlaneSystem(scaled), kHeld).eigenvalues,
              VectorNear(eigenvalues, 1e-13));
  // The system is a mean of a a^T. Its trace is mean |p x n|^2 / mean |p|^2 + |n|^2, which is at
  // most 2.
  EXPECT_GT(eigenvalues[0], 0);
  EXPECT_LE(eigenvalues.sum(), 2);
  EXPECT_TRUE(std::is_sorted(eigenvalues.data(), eigenvalues.data() + 6));
}

// Plane z = 2: two translations and one rotation are unobservable.
Correspondences Plane() {
  Correspondences plane;
  std::mt19937_64 rng(6);
  for (int i = 0; i < 100; ++i) {
    Eigen::Vector3d p = RandomVector(1, &rng);
    p.z() = 2;
    plane.Add(p, p + RandomVector(0.01, &rng), {0, 0, -1}, {0, 0, -1}, 1);
  }
  return plane;
}

TEST(Observe, FindsUnobservableDirections) {
  const NormalSystem system = PointToPlaneSystem(Plane());
  const Observability plane = Observe(system, kHeld);
  EXPECT_TRUE(plane.Degenerate());
  ASSERT_EQ(plane.degenerate_count, 3);
  EXPECT_NEAR(plane.eigenvalues[2], 0, 1e-14);
  EXPECT_GT(plane.eigenvalues[3], 1e-3);
  for (const Vector6d& direction : plane.DegenerateDirections()) {
    // Rotations about z and translations along x and y map the plane to itself.
    EXPECT_THAT(Eigen::Vector3d(direction[0], direction[1], direction[5]),
                VectorNear(Eigen::Vector3d::Zero().eval(), 1e-7));
    EXPECT_GT(direction.norm(), 0.1);
    EXPECT_NEAR(direction.dot(system.hessian * direction), 0, 1e-12);
  }
}

TEST(Observe, HeldRemovesUnobservableDirections) {
  const Observability plane = Observe(PointToPlaneSystem(Plane()), kHeld);
  Vector6d increment;
  increment << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  const Vector6d held = plane.Held(increment);
  EXPECT_NEAR(held[2], 0, 1e-12);
  EXPECT_THAT(Eigen::Vector3d(held[0], held[1], held[5]),
              VectorNear(Eigen::Vector3d(0.1, 0.2, 0.6), 1e-7));
  EXPECT_THAT(plane.Held(held), VectorNear(held, 1e-12));
}

TEST(SolveObservable, IsLeastSquaresIncrementIfAllDirectionsAreObservable) {
  std::mt19937_64 rng(7);
  const NormalSystem system = PointToPlaneSystem(RandomCorrespondences(200, 0.1, &rng));
  const Observability all = Observe(system, kHeld);
  ASSERT_FALSE(all.Degenerate());
  EXPECT_THAT(system.hessian * SolveObservable(system, all),
              VectorNear(system.right_side, 1e-9 * system.right_side.norm()));
}

TEST(SolveObservable, MinimisesResidualOfPlane) {
  const NormalSystem system = PointToPlaneSystem(Plane());
  const Vector6d x = SolveObservable(system, Observe(system, kHeld));
  EXPECT_TRUE(x.allFinite());
  EXPECT_THAT(system.hessian * x, VectorNear(system.right_side, 1e-9));
}

TEST(Observe, AllDirectionsAreUnobservableWithoutPairs) {
  const Observability nothing = Observe(NormalSystem(), {0, 0});
  EXPECT_EQ(nothing.degenerate_count, 6);
  EXPECT_TRUE(nothing.eigenvalues.isZero(0));
}

// A plane with noisy normals on both sides: noise adds spurious information to the unobservable
// directions. A corner has much more information.
TEST(Observe, IgnoresSpuriousInformationOfNormalNoise) {
  std::mt19937_64 rng(9);
  std::normal_distribution<double> normal(0, 0.05);
  const auto noisy = [&](const Eigen::Vector3d& n) -> Eigen::Vector3d {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return (n + Eigen::Vector3d(x, y, z)).normalized();
  };
  Correspondences plane, corner;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 2) + RandomVector(1, &rng);
    const Eigen::Vector3d n = -Eigen::Vector3d::UnitZ(), side = Eigen::Vector3d::Unit(i % 3);
    const Eigen::Vector3d on_plane(p.x(), p.y(), 2);
    plane.Add(on_plane, on_plane, noisy(n), noisy(n), 1);
    corner.Add(p, p, noisy(side), noisy(side), 1);
  }
  const NormalSystem system = PointToPlaneSystem(plane), held = PointToPlaneSystem(corner);
  EXPECT_EQ(Observe(system, {1e-6, 0}).degenerate_count, 0);
  EXPECT_EQ(Observe(system, {1e-6, 1.2}).degenerate_count, 3);
  EXPECT_EQ(Observe(held, {1e-6, 20}).degenerate_count, 0);
  // Spurious information is not trusted. The other directions have the information of 20,000 exact
  // points.
  constexpr double kMinVarianceFactor = 1e-3;
  constexpr double kScale = kSharedPoints * kMinVarianceFactor;
  const Matrix6d trusted = kScale * ConservativeInformation(system, 1);
  EXPECT_LT(trusted(3, 3), 0.05 * system.hessian(3, 3));
  EXPECT_LT(trusted(4, 4), 0.05 * system.hessian(4, 4));
  EXPECT_GT(trusted(5, 5), 0.95 * system.hessian(5, 5));
  EXPECT_THAT(kScale * ConservativeInformation(held, 1),
              VectorNear(held.hessian, 0.05 * held.hessian.norm()));
  // All information along x is spurious: the mean of 20,000 values with a relative spread of 2 has
  // an error of 1 %.
  EXPECT_NEAR(system.SpuriousInformation()(3, 3), system.hessian(3, 3),
              5 * 0.01 * system.hessian(3, 3));
}

TEST(ConservativeInformation, ScalesPhotometricInformation) {
  std::mt19937_64 rng(9);
  NormalSystem system = PointToPlaneSystem(RandomCorrespondences(200, 0.1, &rng));
  const Matrix6d of_points = ConservativeInformation(system, 0.01);
  PhotometricSystem intensities;
  intensities.hessian = 1000 * Matrix6d::Identity();
  system.Add(intensities);
  const Matrix6d added = ConservativeInformation(system, 0.01) - of_points;
  EXPECT_THAT(kSharedPoints * system.VarianceFactor() * added,
              VectorNear((10 * Matrix6d::Identity()).eval(), 1e-6));
}

// Both covariances have the same floor and the same disagreement, which cancel.
TEST(RealisticCovariance, GrowsWithNumberOfPointsWithCommonError) {
  const Matrix6d covariance = (1e-6 * Vector6d::LinSpaced(1, 6)).asDiagonal();
  const Matrix6d difference =
      RealisticCovariance(3 * covariance, 0.01, 0.02) - RealisticCovariance(covariance, 0.01, 0.02);
  EXPECT_THAT(difference, VectorNear((2 * kSharedPoints * covariance).eval(), 1e-12));
}

TEST(CovarianceOf, IsInverseInformationTimesVarianceFactor) {
  std::mt19937_64 rng(8);
  const NormalSystem system = PointToPlaneSystem(RandomCorrespondences(200, 0.1, &rng));
  EXPECT_NEAR(system.VarianceFactor(), system.weighted_square_sum / 194, 1e-15);
  EXPECT_THAT(system.hessian * CovarianceOf(system),
              VectorNear((system.VarianceFactor() * Matrix6d::Identity()).eval(), 1e-12));
}

// Monte Carlo test: targets with normal noise along known normals. The normalised squared error
// (NEES) of the poses has a chi-square distribution with six degrees of freedom. The mean of N
// trials is chi-square with 6 N degrees of freedom, divided by N. Its 99.9 % interval is about 6 +-
// 3.29 sqrt(12 / N).
TEST(CovarianceOf, IsConsistentWithMonteCarloErrors) {
  constexpr int kTrials = 1000, kPairs = 300;
  constexpr double kSigma = 0.01;
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  PoseSolverOptions options;
  options.error_model.kernel.type = RobustKernelType::kNone;
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(options);
  double with_known_sigma = 0, with_estimated_sigma = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Correspondences exact = ExactCorrespondences(kPairs, Rigid3d(), &rng);
    Correspondences pairs;
    for (int i = 0; i < kPairs; ++i) {
      pairs.Add(exact.p(i), exact.q(i) + kSigma * normal(rng) * exact.n(i), exact.n(i), exact.m(i),
                1 / (kSigma * kSigma));
    }
    // The remaining error of the first step is the square of 1e-3. A second step leaves 1e-9.
    const Vector6d first = solver->Step(pairs).increment;
    const Correspondences moved = Moved(pairs, LeftIncrement<double>(first, Rigid3d()));
    const StepResult step = solver->Step(moved);
    const Vector6d error = first + step.increment;
    with_known_sigma += error.dot(step.system.hessian * error);
    with_estimated_sigma += error.dot(CovarianceOf(step.system).ldlt().solve(error));
  }
  const double half_width = 3.29 * std::sqrt(12.0 / kTrials);
  EXPECT_NEAR(with_known_sigma / kTrials, 6, half_width);
  // The estimated variance leads to an F distribution with f = 294. Its mean is larger by f / (f -
  // 2), and its spread is slightly larger.
  const double f = kPairs - 6;
  EXPECT_NEAR(with_estimated_sigma / kTrials, 6 * f / (f - 2), 1.02 * half_width);
}

}  // namespace

}  // namespace surfit::testing
