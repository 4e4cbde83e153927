#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "cost_functions/pose.h"

namespace surfit {

using PoseInformation = Eigen::Matrix<double, 6, 6>;

// Matrix U with U^T U = information. With the Cholesky factor L L^T of the information, U is L^T; L
// is wrong unless the matrix is diagonal. A singular matrix (unmeasured directions) has no such
// factor. U is then computed from eigenvectors, with negative eigenvalues set to 0.
inline PoseInformation InformationRoot(const PoseInformation& information) {
  const Eigen::LLT<PoseInformation> cholesky(information);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<PoseInformation> eigen(information);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

// residuals = U (rotation log [rad], translation [m]) of an error transform, with U =
// InformationRoot(information): |residuals|^2 = e^T information e.
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

  // Returns U.
  const PoseInformation& root() const { return root_; }

 private:
  PoseInformation root_;
};

}  // namespace surfit
