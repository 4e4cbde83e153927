#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "cost_functions/dual.h"
#include "cost_functions/random_functors.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// Autodiff Jacobian of one functor on a manifold: derivatives of the residuals by the increment.
template <typename Functor>
Eigen::MatrixXd Jacobian(const Functor& functor, const Rigid3d& pose,
                         const ceres::Manifold& manifold) {
  using Rows = Eigen::Matrix<double, Functor::kResidualSize, kPoseSize, Eigen::RowMajor>;
  const PoseBlock block = AsBlock(pose);
  const double* parameters = block.data();
  Eigen::Matrix<double, Functor::kResidualSize, 1> residuals;
  Rows ambient;
  double* jacobian = ambient.data();
  const std::unique_ptr<ceres::CostFunction> cost(PerPointCost(functor));
  EXPECT_TRUE(cost->Evaluate(&parameters, residuals.data(), &jacobian));
  Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor> plus;
  manifold.PlusJacobian(block.data(), plus.data());
  return ambient * plus;
}

// Rounding of coordinates of a few metres, divided by sigmas of millimetres.
constexpr double kRounding = 1e-11;

TEST(PointToPlane, JacobianAgreesWithClosedForm) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d pose = RandomPose(1, 2, &rng);
    const Match m = RandomMatch(RandomPose(1, 2, &rng), 0.1, &rng);
    const PointToPlane functor(m.p, m.q, m.n, m.sigma_m);
    const Eigen::Vector3d turned = pose.rotation * m.p, y = pose * m.p;
    Eigen::Matrix<double, 1, 6> left, product;
    left << y.cross(m.n).transpose(), m.n.transpose();
    product << turned.cross(m.n).transpose(), m.n.transpose();
    EXPECT_THAT(Jacobian(functor, pose, LeftPoseManifold()),
                VectorNear(left / m.sigma_m, kRounding));
    EXPECT_THAT(Jacobian(functor, pose, ProductPoseManifold()),
                VectorNear(product / m.sigma_m, kRounding));
    double residual = 0;
    functor(AsBlock(pose).data(), &residual);
    EXPECT_NEAR(residual, m.n.dot(y - m.q) / m.sigma_m, kRounding);
  }
}

TEST(PointToPoint, JacobianAgreesWithClosedForm) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d pose = RandomPose(1, 2, &rng);
    const Match m = RandomMatch(RandomPose(1, 2, &rng), 0.1, &rng);
    const PointToPoint functor(m.p, m.q, m.sigma_m);
    const Eigen::Vector3d y = pose * m.p;
    Eigen::Matrix<double, 3, 6> left;
    left << -CrossMatrix<double>(y), Eigen::Matrix3d::Identity();
    EXPECT_THAT(Jacobian(functor, pose, LeftPoseManifold()),
                VectorNear(left / m.sigma_m, kRounding));
    Eigen::Vector3d residuals;
    functor(AsBlock(pose).data(), residuals.data());
    EXPECT_THAT(residuals, VectorNear((y - m.q) / m.sigma_m, kRounding));
  }
}

TEST(SymmetricPointToPlane, IsZeroForAllPointsOfOneSphere) {
  std::mt19937_64 rng(3);
  const Eigen::Vector3d center(0.3, -0.2, 2);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d m = RandomVector(1, &rng).normalized();
    const Eigen::Vector3d n = (m + 0.3 * RandomVector(1, &rng)).normalized();
    const SymmetricPointToPlane functor(center + 0.5 * m, m, center + 0.5 * n, n, 0.01);
    double residual = 1;
    functor(AsBlock(Rigid3d()).data(), &residual);
    EXPECT_NEAR(residual, 0, kRounding);
  }
}

TEST(SymmetricPointToPlane, IsPointToPlaneForEqualNormals) {
  std::mt19937_64 rng(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d pose = RandomPose(1, 2, &rng);
    const Match m = RandomMatch(pose, 0.1, &rng);
    double symmetric = 0, plain = 0;
    SymmetricPointToPlane(m.p, m.m, m.q, m.n, m.sigma_m)(AsBlock(pose).data(), &symmetric);
    PointToPlane(m.p, m.q, m.n, m.sigma_m)(AsBlock(pose).data(), &plain);
    EXPECT_NEAR(symmetric, plain, kRounding);
  }
}

TEST(PlaneToPlane, CostIsMahalanobisDistance) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Match m = RandomMatch(RandomPose(1, 2, &rng), 0.1, &rng);
    Eigen::Matrix3d root;
    for (int i = 0; i < 3; ++i) root.col(i) = RandomVector(1, &rng);
    const Eigen::Matrix3d covariance =
        root * root.transpose() + 0.1 * Eigen::Matrix3d::Identity();  // full, not diagonal
    const Rigid3d pose = RandomPose(1, 2, &rng);
    Eigen::Vector3d residuals;
    PlaneToPlane(m.p, m.q, covariance)(AsBlock(pose).data(), residuals.data());
    const Eigen::Vector3d gap = pose * m.p - m.q;
    const double expected = gap.dot(covariance.inverse() * gap);
    EXPECT_NEAR(residuals.squaredNorm(), expected, 1e-12 * expected);
  }
}

TEST(PlaneToPlane, CovarianceIsSmallAlongNormalOnly) {
  const Eigen::Vector3d n = Eigen::Vector3d(1, 2, -2) / 3, along(2, -1, 0);
  const Eigen::Matrix3d c = PlaneToPlane::CovarianceOfPlane(n, 0.01, 0.1);
  EXPECT_THAT(c * n, VectorNear(1e-4 * n, 1e-15));
  EXPECT_THAT(c * along, VectorNear(1e-2 * along, 1e-15));
}

TEST(Photometric, IsDifferenceOfIntensitiesInLinearImage) {
  std::mt19937_64 rng(6);
  const Eigen::Vector2d gradient(0.7, -1.3);
  const auto intensity = [&](double u, double v) {
    return 50 + gradient.dot(Eigen::Vector2d(u, v));
  };
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d pose = RandomPose(0.1, 0.1, &rng);
    const Match m = RandomMatch(pose, 0, &rng);
    Photometric functor(500, 510, 320, 240);
    functor.SetPoint(m.p, 33, 300, 200, intensity(300, 200), gradient, 4);
    const Eigen::Vector3d y = pose * m.p;
    const double u = 500 * y.x() / y.z() + 320, v = 510 * y.y() / y.z() + 240;
    double residual = 0;
    functor(AsBlock(pose).data(), &residual);
    EXPECT_NEAR(residual, (intensity(u, v) - 33) / 4, kRounding);
  }
}

// On exact data, each residual recovers each of the six degrees of freedom in both directions, on
// all three parameterisations.
template <typename Functor>
class PoseRecovery : public ::testing::Test {};
using Geometric = ::testing::Types<PointToPoint, PointToPlane, SymmetricPointToPlane, PlaneToPlane>;
TYPED_TEST_SUITE(PoseRecovery, Geometric);

TYPED_TEST(PoseRecovery, RecoversEachDegreeOfFreedom) {
  const Rigid3d truth(QuaternionExp<double>({0.2, -0.1, 0.3}), {0.1, 0.2, -0.1});
  const auto functors = RandomFunctors<TypeParam>(200, truth, 0, 7);
  for (int axis = 0; axis < 6; ++axis) {
    for (const double size : {-0.1, 0.1}) {
      Eigen::Matrix<double, 6, 1> off = Eigen::Matrix<double, 6, 1>::Zero();
      off[axis] = size;
      const Rigid3d initial = LeftIncrement<double>(off, truth);
      const auto expected = RigidNear(truth, 1e-9, 1e-9);
      EXPECT_THAT(SolvePerPoint(functors, initial, new LeftPoseManifold), expected) << axis;
      EXPECT_THAT(SolvePerPoint(functors, initial, new ProductPoseManifold), expected) << axis;
      EXPECT_THAT(SolveWithAngleAxis(functors, initial), expected) << axis;
    }
  }
}

TYPED_TEST(PoseRecovery, ReachesSameMinimumWithAllParameterisations) {
  const Rigid3d truth(QuaternionExp<double>({0.2, -0.1, 0.3}), {0.1, 0.2, -0.1});
  const auto functors = RandomFunctors<TypeParam>(200, truth, 0.02, 8);
  const Rigid3d initial(QuaternionExp<double>({0.25, -0.05, 0.3}), {0.1, 0.25, -0.1});
  const Rigid3d left = SolvePerPoint(functors, initial, new LeftPoseManifold);
  const auto expected = RigidNear(left, 1e-8, 1e-8);
  EXPECT_THAT(SolvePerPoint(functors, initial, new ProductPoseManifold), expected);
  EXPECT_THAT(SolveWithAngleAxis(functors, initial), expected);
  EXPECT_GT((left.translation - truth.translation).norm(), 1e-5);
}

using D2 = Dual<Lanes<double>, 2>;
using Jet = ceres::Jet<double, 2>;

Jet Select(bool condition, const Jet& a, const Jet& b) { return condition ? a : b; }

// All operations of variables with derivatives (x, y), data without derivatives (c) and literals.
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

TEST(Dual, AgreesWithCeresJets) {
  const double xs[4] = {0.7, 2.3, 1.1, 0.2}, ys[4] = {1.9, 0.4, 1.1, 3.1},
               cs[4] = {-1.1, 3.7, 0.6, -0.3};
  const D2 lanes = AllOperations(D2::Variable(Lanes<double>::Load(xs), 0),
                                 D2::Variable(Lanes<double>::Load(ys), 1), Lanes<double>::Load(cs));
  for (int k = 0; k < 4; ++k) {
    const Jet jet = AllOperations(Jet(xs[k], 0), Jet(ys[k], 1), cs[k]);
    // A few dozen roundings of values below 100.
    EXPECT_NEAR(lanes.value[k], jet.a, 1e-12);
    EXPECT_NEAR(lanes.derivative[0][k], jet.v[0], 1e-12);
    EXPECT_NEAR(lanes.derivative[1][k], jet.v[1], 1e-12);
  }
}

TEST(Instructions, GiveBitwiseIdenticalResults) {
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
