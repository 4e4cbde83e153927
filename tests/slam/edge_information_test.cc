#include "slam/edge_information.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace surfit {
namespace {

constexpr int kBetween = 12;

// Held a hundred times less along x, as before a wall with an upright edge.
IcpResult HeldLittleAlongX() {
  IcpResult icp;
  Vector6d sigmas = Vector6d::Constant(1e-5);
  sigmas[3] = 1e-3;
  icp.covariance = sigmas.cwiseAbs2().asDiagonal();
  icp.information = icp.covariance->inverse();
  return icp;
}

Matrix6d CovarianceOfOdometry(const IcpResult& icp, int frames, const Rigid3d& a_from_b) {
  return OdometryInformation(icp, frames, a_from_b, EdgeNoise()).inverse();
}

// The prior that holds free directions at 0.1 takes (0.017 / 0.1)^2 = 3 % of what is held least.
TEST(EdgeInformation, OdometryDriftsAsAWalkAtRandom) {
  const EdgeNoise noise;
  const Matrix6d covariance = CovarianceOfOdometry(HeldLittleAlongX(), kBetween, Rigid3d());
  const double walk = noise.shared_points * kBetween;
  EXPECT_NEAR(covariance(3, 3), walk * 1e-6 + std::pow(noise.odometry_m, 2), 0.03 * walk * 1e-6);
  EXPECT_NEAR(covariance(4, 4), walk * 1e-10 + std::pow(noise.odometry_m, 2), 1e-10);
  EXPECT_NEAR(covariance(0, 0), walk * 1e-10 + std::pow(noise.odometry_rad, 2), 1e-10);
  EXPECT_GT(covariance(3, 3), 1e3 * covariance(4, 4));
}

// What the later camera sees along x is along y of the earlier one, a quarter of a turn before.
TEST(EdgeInformation, WhatIsHeldLittleTurnsWithTheCamera) {
  const Rigid3d quarter(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                        {0, 0, 0});
  const Matrix6d covariance = CovarianceOfOdometry(HeldLittleAlongX(), kBetween, quarter);
  EXPECT_GT(covariance(4, 4), 50 * covariance(3, 3));
}

TEST(EdgeInformation, HoldsFreeDirectionsLooselyHoweverManyFrames) {
  IcpResult icp;  // which says nothing
  for (const int frames : {1, 1000}) {
    const Matrix6d covariance = CovarianceOfOdometry(icp, frames, Rigid3d());
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(covariance(i, i)), 0.1, 1e-3) << frames;
  }
}

}  // namespace
}  // namespace surfit
