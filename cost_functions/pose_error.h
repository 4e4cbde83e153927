#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "cost_functions/pose.h"

namespace surfit {

using PoseInformation = Eigen::Matrix<double, 6, 6>;

// Matrix U with U^T U = information, which is symmetric and in the order (rotation, translation):
// the transposed Cholesky factor, or from the eigenvectors of a singular matrix. Negative
// eigenvalues are set to 0.
inline PoseInformation InformationRoot(const PoseInformation& information) {
  const Eigen::LLT<PoseInformation> cholesky(information);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<PoseInformation> eigen(information);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

// Residuals U e of an error transform, in standard deviations, with e = (rotation vector [rad],
// translation [m]) and U = InformationRoot(information). |U e|^2 = e^T information e for
// semidefinite information.
class WhitenedPoseError {
 public:
  explicit WhitenedPoseError(const PoseInformation& information)
      : root_(InformationRoot(information)) {}

  template <typename T>
  void operator()(const Rigid3<T>& error, T* residuals) const {
    Eigen::Matrix<T, 6, 1> e;
    e << QuaternionLog<T>(error.rotation), error.translation;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r = root_.cast<T>() * e;
  }

  const PoseInformation& root() const { return root_; }

 private:
  PoseInformation root_;
};

}  // namespace surfit
