#include "tracking/motion/motion_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace surfit {
namespace {

constexpr double kPriorFrame_s = 1. / 30;

Matrix6d Diagonal(double of_turn, double of_shift) {
  Vector6d values;
  values << Eigen::Vector3d::Constant(of_turn), Eigen::Vector3d::Constant(of_shift);
  return values.asDiagonal();
}

Rigid3d Shifted(double x_m, double y_m) {
  return Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_m, y_m, 0));
}

constexpr double kNoBound = std::numeric_limits<double>::infinity();

TEST(MostLikely, CombinesPriorAndRegistrationByInformation) {
  const ExpectedPose expected = {Shifted(1, 2), Diagonal(1e-4, 1e-4)};
  Matrix6d information = Diagonal(1e10, 0);
  information(3, 3) = 1e10;  // much more than the prior
  information(4, 4) = 1e4;   // equal to the prior; zero along z
  const Rigid3d registered(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1.01, 2.02, 0.03));
  const ExpectedPose likely = MostLikely(expected, registered, information, kNoBound);
  EXPECT_NEAR(likely.target_from_source.translation.x(), 1.01, 1e-6);
  EXPECT_NEAR(likely.target_from_source.translation.y(), 2.01, 1e-6);
  EXPECT_NEAR(likely.target_from_source.translation.z(), 0, 1e-6);
  EXPECT_NEAR(likely.covariance(3, 3), 1e-10, 1e-12);
  EXPECT_NEAR(likely.covariance(4, 4), 0.5e-4, 1e-9);
  EXPECT_NEAR(likely.covariance(5, 5), 1e-4, 1e-9);
}

// The prior has a standard deviation of 1 cm, and the registration of 0.1 mm. Within three standard
// deviations, the registration is used. At ten standard deviations, w = 1 / ((10 / 3)^2 - 1), and w
// / (1 + w) = 0.09 of the motion remains.
TEST(MostLikely, LimitsImplausibleRegistration) {
  const ExpectedPose expected = {Rigid3d(), Diagonal(1e-4, 1e-4)};
  const Matrix6d information = Diagonal(1e8, 1e8);
  const ExpectedPose near = MostLikely(expected, Shifted(0.029, 0), information, 3);
  EXPECT_NEAR(near.target_from_source.translation.x(), 0.029, 1e-5);
  const ExpectedPose far = MostLikely(expected, Shifted(0.1, 0.01), information, 3);
  EXPECT_NEAR(far.target_from_source.translation.x(), 0.009, 1e-5);
  EXPECT_NEAR(far.target_from_source.translation.y(), 0.01, 1e-5);
  EXPECT_NEAR(far.covariance(3, 3), 0.91e-4, 1e-9);
  EXPECT_NEAR(far.covariance(4, 4), 1e-8, 1e-11);
}

TEST(MostLikely, IsThePredictedPoseWithoutUsableInformation) {
  const ExpectedPose expected = {Shifted(1, 2), Diagonal(1e-4, 1e-4)};
  Matrix6d information = Diagonal(1e8, 1e8);
  information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const ExpectedPose likely = MostLikely(expected, Shifted(1.01, 2), information, 3);
  EXPECT_EQ(likely.target_from_source.Matrix(), expected.target_from_source.Matrix());
  EXPECT_EQ(likely.covariance, expected.covariance);
}

// In another frame at this distance, a rotation increment moves the origin by the lever arm.
TEST(ExpectedPoseIn, MapsRotationToTranslationCovariance) {
  const Matrix6d turns_alone = Diagonal(1e-4, 0);
  const ExpectedPose moved = In(Shifted(2, 0), {Rigid3d(), turns_alone});
  EXPECT_DOUBLE_EQ(moved.target_from_source.translation.x(), 2);
  EXPECT_NEAR(moved.covariance(3, 3), 0, 1e-15);     // along the arm
  EXPECT_NEAR(moved.covariance(4, 4), 4e-4, 1e-15);  // 2 m times 0.01 rad
  EXPECT_NEAR(moved.covariance(0, 0), 1e-4, 1e-15);
}

TEST(MotionPrior, GrowsByAccelerationsOnly) {
  MotionPrior prior(2, 4);
  prior.Keep(Diagonal(0, 0), kPriorFrame_s);
  const Matrix6d covariance = prior.Covariance(kPriorFrame_s);
  const double square = kPriorFrame_s * kPriorFrame_s;
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 4 * square, 1e-12);
  EXPECT_NEAR(std::sqrt(covariance(5, 5)), 2 * square, 1e-12);
}

TEST(MotionPrior, ExtrapolatesVelocityCovariance) {
  MotionPrior prior(1e-9, 1e-9);
  prior.Keep(Diagonal(0, 1e-6), kPriorFrame_s);
  EXPECT_NEAR(prior.Covariance(3 * kPriorFrame_s)(4, 4), 9e-6, 1e-12);
}

TEST(MotionPrior, HasLargeCovarianceAfterForget) {
  MotionPrior prior(2, 4);
  prior.Keep(Diagonal(0, 0), kPriorFrame_s);
  prior.Forget();
  EXPECT_GT(std::sqrt(prior.Covariance(kPriorFrame_s)(3, 3)), 0.09);
}

}  // namespace
}  // namespace surfit
