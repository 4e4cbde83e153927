#include "surfit/geometry/rigid3.h"

#include <gtest/gtest.h>

#include <random>

namespace surfit::testing {
namespace {

// Matrix exponential by its series. The 40th term is below 1e-28 for norms below 3.
Eigen::Matrix3d Exp(const Eigen::Matrix3d& matrix) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Identity(), term = sum;
  for (int k = 1; k <= 40; ++k) {
    term = term * matrix / k;
    sum += term;
  }
  return sum;
}

template <typename Scalar>
class Rigid3Test : public ::testing::Test {
 protected:
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Vector6 = Eigen::Matrix<Scalar, 6, 1>;

  static constexpr Scalar kTolerance = 100 * std::numeric_limits<Scalar>::epsilon();

  Vector3 RandomVector(Scalar size) {
    std::uniform_real_distribution<Scalar> uniform(-size, size);
    return {uniform(rng_), uniform(rng_), uniform(rng_)};
  }
  Rigid3<Scalar> RandomPose() {
    return Rigid3<Scalar>(QuaternionExp<Scalar>(RandomVector(1.7)), RandomVector(3));
  }
  // Rotation vectors at the identity, at 1e-8, on both sides of the switch to the series, and at
  // random.
  std::vector<Vector3> RotationVectors() {
    std::vector<Vector3> vectors = {Vector3::Zero()};
    for (const Scalar size : {1e-8, 1e-5, 0.9e-4, 1.1e-4, 0.1, 1.0, 1.7}) {
      for (int i = 0; i < 10; ++i) vectors.push_back(RandomVector(size));
    }
    return vectors;
  }
  std::mt19937_64 rng_{7};
};

using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Rigid3Test, Scalars);

TYPED_TEST(Rigid3Test, ExpIsMatrixExponentialOfCrossMatrix) {
  for (const auto& w : this->RotationVectors()) {
    const Eigen::Matrix3d expected = Exp(CrossMatrix<double>(w.template cast<double>()));
    const auto actual = QuaternionExp<TypeParam>(w).toRotationMatrix();
    EXPECT_LT((actual.template cast<double>() - expected).norm(), this->kTolerance);
  }
}

TYPED_TEST(Rigid3Test, LogInvertsExp) {
  for (const auto& w : this->RotationVectors()) {
    const auto back = QuaternionLog<TypeParam>(QuaternionExp<TypeParam>(w));
    EXPECT_LT((back - w).norm(), this->kTolerance * std::max<TypeParam>(w.norm(), 1e-6));
  }
}

TYPED_TEST(Rigid3Test, LogIsIndependentOfSignOfQuaternion) {
  auto q = QuaternionExp<TypeParam>({0.1, -0.2, 0.3});
  q.coeffs() = -q.coeffs();
  EXPECT_LT((QuaternionLog<TypeParam>(q) - typename TestFixture::Vector3(0.1, -0.2, 0.3)).norm(),
            this->kTolerance);
}

TYPED_TEST(Rigid3Test, InverseAndCompositionAgreeWithMatrices) {
  for (int i = 0; i < 20; ++i) {
    const auto a = this->RandomPose(), b = this->RandomPose();
    EXPECT_LT(((a * b).Matrix() - a.Matrix() * b.Matrix()).norm(), this->kTolerance);
    EXPECT_LT(((a * a.Inverse()).Matrix() - Rigid3<TypeParam>().Matrix()).norm(), this->kTolerance);
    const auto x = this->RandomVector(2);
    EXPECT_LT((a * (b * x) - (a * b) * x).norm(), this->kTolerance);
  }
}

TYPED_TEST(Rigid3Test, LeftIncrementMovesThePointAfterThePose) {
  const auto pose = this->RandomPose();
  const auto x = this->RandomVector(2);
  typename TestFixture::Vector6 increment;
  increment << 0.01, -0.02, 0.03, 0.1, 0.2, -0.3;
  const typename TestFixture::Vector3 w = increment.template head<3>();
  const typename TestFixture::Vector3 expected =
      QuaternionExp<TypeParam>(w) * (pose * x) + increment.template tail<3>();
  EXPECT_LT((LeftIncrement(increment, pose) * x - expected).norm(), this->kTolerance);
}

TYPED_TEST(Rigid3Test, RotationStaysUnitAfterManyIncrements) {
  auto pose = this->RandomPose();
  typename TestFixture::Vector6 increment;
  increment << 0.1, -0.2, 0.3, 0, 0, 0;
  for (int i = 0; i < 10000; ++i) pose = LeftIncrement(increment, pose);
  EXPECT_NEAR(pose.rotation.norm(), 1, this->kTolerance);
}

// IncrementTransform() maps an increment of b_from_c to the increment of a_from_c.
TYPED_TEST(Rigid3Test, IncrementTransformMapsIncrementsBetweenFrames) {
  const auto a_from_b = this->RandomPose(), b_from_c = this->RandomPose();
  typename TestFixture::Vector6 increment;
  increment << 1e-3, -2e-3, 1e-3, 2e-3, 1e-3, -1e-3;
  const auto moved = a_from_b * LeftIncrement(increment, b_from_c);
  const typename TestFixture::Vector6 same = IncrementTransform(a_from_b) * increment;
  const auto expected = LeftIncrement(same, a_from_b * b_from_c);
  EXPECT_LT((moved.Matrix() - expected.Matrix()).norm(), 1e-4);  // second-order error
  EXPECT_GT((moved.Matrix() - (a_from_b * b_from_c).Matrix()).norm(), 1e-3);
}

TYPED_TEST(Rigid3Test, RotationMatrixIsReorthonormalised) {
  const auto q = QuaternionExp<TypeParam>({0.1, -0.2, 0.3});
  const Rigid3<TypeParam> pose(Eigen::Matrix<TypeParam, 3, 3>(q.toRotationMatrix() * 1.01),
                               TestFixture::Vector3::Zero());
  const auto r = pose.rotation.toRotationMatrix();
  EXPECT_LT((r * r.transpose() - Eigen::Matrix<TypeParam, 3, 3>::Identity()).norm(),
            this->kTolerance);
}

}  // namespace
}  // namespace surfit::testing
