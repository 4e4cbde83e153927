#include "places/loop_covariance.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr double kSharing = 25;  // points that share their noise: the depth filter's window
// In simulated rooms all loops are within three sigmas of it, most far within; a real Kinect's
// loops differ from each other by about as much.
constexpr double kFloorRad = 0.002, kFloorM = 0.004;

}  // namespace

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0., eigen.eigenvalues()[2]));
}

Vector6d WeakestIncrement(const Matrix6d& information, double distance_m) {
  Matrix6d scaled = information;
  scaled.topRows<3>() /= distance_m;
  scaled.leftCols<3>() /= distance_m;
  Vector6d increment = Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled).eigenvectors().col(0);
  increment.head<3>() /= distance_m;
  return increment;
}

Matrix6d LoopCovariance(const Matrix6d& covariance, double disagreement_rad,
                        double disagreement_m) {
  Matrix6d realistic = kSharing * covariance;
  realistic.diagonal().head<3>().array() +=
      kFloorRad * kFloorRad + disagreement_rad * disagreement_rad;
  realistic.diagonal().tail<3>().array() += kFloorM * kFloorM + disagreement_m * disagreement_m;
  return realistic;
}

Matrix6d InformationOf(const Matrix6d& covariance) {
  const Matrix6d information = covariance.inverse();
  return (information + information.transpose()) / 2;
}

}  // namespace surfit
