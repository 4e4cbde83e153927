#include "refinement/joint_covariance.h"

#include <Eigen/Cholesky>
#include <limits>

#include "cost_functions/plane_inverse_depth.h"

namespace surfit {
namespace {

// The indices of what is free and occurs in the residuals.
std::vector<Eigen::Index> FreeIndices(const Eigen::MatrixXd& hessian,
                                      const std::vector<bool>& held) {
  const Eigen::Index calibration = hessian.rows() - kCalibrationSize;
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = kPoseTangentSize; i < hessian.rows(); ++i) {
    if (i >= calibration && held[i - calibration]) continue;
    if (hessian(i, i) > 0) free.push_back(i);
  }
  return free;
}

// The inverse of these rows and columns, zero elsewhere, by the matrix scaled to a diagonal of
// ones: metres, radians and pixels differ by orders of magnitude.
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& lower, const std::vector<Eigen::Index>& free) {
  const Eigen::MatrixXd full = lower.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd hessian = full(free, free);
  const Eigen::VectorXd scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scale.asDiagonal() * hessian * scale.asDiagonal());
  const Eigen::MatrixXd inverse =
      ldlt.solve(Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols()));
  Eigen::MatrixXd embedded = Eigen::MatrixXd::Zero(lower.rows(), lower.cols());
  embedded(free, free) = scale.asDiagonal() * inverse * scale.asDiagonal();
  return embedded;
}

}  // namespace

JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& held_calibration) {
  const Eigen::MatrixXd inverse =
      InverseOf(system.hessian, FreeIndices(system.hessian, held_calibration));
  JointCovariance covariance;
  covariance.calibration = inverse.bottomRightCorner(kCalibrationSize, kCalibrationSize);
  const Eigen::Index poses_end = inverse.rows() - kCalibrationSize;
  for (Eigen::Index i = 0; i < poses_end; i += kPoseTangentSize) {
    covariance.poses.push_back(inverse.block<kPoseTangentSize, kPoseTangentSize>(i, i));
    const bool held = i == 0, shares_none = !(system.hessian(i, i) > 0);
    if (!held && shares_none) {
      covariance.poses.back().diagonal().setConstant(std::numeric_limits<double>::infinity());
    }
  }
  return covariance;
}

}  // namespace surfit
