#include "refinement/calibration_covariance.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "cost_functions/plane_inverse_depth.h"

namespace surfit {
namespace {

// The indices of what is free.
std::vector<Eigen::Index> FreeIndices(Eigen::Index size, const std::vector<bool>& held) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = kPoseTangentSize; i < size - kCalibrationSize; ++i) free.push_back(i);
  for (int i = 0; i < kCalibrationSize; ++i) {
    if (!held[i]) free.push_back(size - kCalibrationSize + i);
  }
  return free;
}

}  // namespace

Eigen::MatrixXd CalibrationCovariance(const ReducedSystem& system,
                                      const std::vector<bool>& held_calibration) {
  const Eigen::Index size = system.gradient.size();
  const std::vector<Eigen::Index> free = FreeIndices(size, held_calibration);
  const Eigen::MatrixXd full = system.hessian.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd hessian = full(free, free);
  // Scaled to a diagonal of ones: metres, radians and pixels differ by orders of magnitude.
  const Eigen::VectorXd scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scale.asDiagonal() * hessian * scale.asDiagonal());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  const Eigen::Index begin = size - kCalibrationSize;
  for (std::size_t j = 0; j < free.size(); ++j) {
    if (free[j] < begin) continue;
    Eigen::VectorXd column = Eigen::VectorXd::Unit(hessian.rows(), static_cast<Eigen::Index>(j));
    ldlt.solveInPlace(column);
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (free[i] < begin) continue;
      const auto row = static_cast<Eigen::Index>(i);
      covariance(free[i] - begin, free[j] - begin) = column[row] * scale[row] * scale[j];
    }
  }
  return covariance;
}

}  // namespace surfit
