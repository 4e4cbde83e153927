#include "registration/decompositions.h"

#include <gtest/gtest.h>

#include <random>

#include "registration/register_from.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {
namespace {

// Random and positive definite.
Matrix6d RandomCovariance() {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  Matrix6d factor;
  for (double& value : factor.reshaped()) value = 1e-3 * normal(generator);
  return factor * factor.transpose() + 1e-7 * Matrix6d::Identity();
}

TEST(LargestSigma, IsOfTheWorstDirection) {
  const Eigen::Matrix3d turn = QuaternionExp<double>({0.3, -0.2, 0.5}).toRotationMatrix();
  const Eigen::Matrix3d diagonal = Eigen::Vector3d(1e-4, 9e-4, 4e-4).asDiagonal();
  EXPECT_NEAR(LargestSigma(turn * diagonal * turn.transpose()), 0.03, 1e-12);
}

// What holds least is a shift along y; or a turn, where points are near, which moves them less.
TEST(WeakestIncrement, MovesPointsByAMetreAlongWhatIsHeldLeast) {
  Matrix6d information = Matrix6d::Identity();
  information(4, 4) = 0.01;
  EXPECT_NEAR(std::abs(WeakestIncrement(information, 2)[4]), 1, 0.2);
  information = Matrix6d::Identity();
  information(1, 1) = 0.04;
  const Vector6d turn = WeakestIncrement(information, 2);
  EXPECT_NEAR(std::abs(turn[1]), 0.5, 1e-12);
}

TEST(RealisticCovariance, IsLargerThanRegistrationsInEveryDirection) {
  const Matrix6d covariance = RandomCovariance();
  const Matrix6d sure = RealisticCovariance(covariance, 0, 0);
  const Matrix6d doubtful = RealisticCovariance(covariance, 0.003, 0.01);
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(sure(i, i), covariance(i, i));
    EXPECT_NEAR(doubtful(i, i) - sure(i, i), i < 3 ? 9e-6 : 1e-4, 1e-15);
  }
}

TEST(SymmetricInverse, IsSymmetric) {
  const Matrix6d covariance = RandomCovariance();
  const Matrix6d information = SymmetricInverse(covariance);
  EXPECT_EQ(information, Matrix6d(information.transpose()));
  EXPECT_LT((information * covariance - Matrix6d::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace surfit
