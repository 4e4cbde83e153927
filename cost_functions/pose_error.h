#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "cost_functions/pose.h"

namespace surfit {

using PoseInformation = Eigen::Matrix<double, 6, 6>;

// U with U^T U = information. From the Cholesky factor L L^T of the information U is L^T; L itself
// would whiten wrongly as soon as the matrix is not diagonal. Where some directions were not
// measured there is no such factor, and U is made of eigenvectors; eigenvalues below 0 count as 0.
inline PoseInformation InformationRoot(const PoseInformation& information) {
  const Eigen::LLT<PoseInformation> cholesky(information);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<PoseInformation> eigen(information);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

// residuals = U (log of the rotation [rad], translation [m]) of an error transform, with
// U = InformationRoot(information): |residuals|^2 = e^T information e.
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

  // U.
  const PoseInformation& root() const { return root_; }

 private:
  PoseInformation root_;
};

}  // namespace surfit
