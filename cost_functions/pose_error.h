#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "cost_functions/pose.h"

namespace surfit {

using PoseInformation = Eigen::Matrix<double, 6, 6>;

// residuals = U (log of the rotation [rad], translation [m]) of an error transform, with
// U^T U = information: |residuals|^2 = e^T information e. From the Cholesky factor L L^T of the
// information U is L^T; L itself would whiten wrongly as soon as the matrix is not diagonal.
class WhitenedPoseError {
 public:
  explicit WhitenedPoseError(const PoseInformation& information)
      : upper_(information.llt().matrixU()) {}

  template <typename T>
  void operator()(const Rigid3<T>& error, T* residuals) const {
    Eigen::Matrix<T, 6, 1> e;
    e << QuaternionLog<T>(error.rotation), error.translation;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r = upper_.cast<T>() * e;
  }

  // U.
  const PoseInformation& upper() const { return upper_; }

 private:
  PoseInformation upper_;
};

}  // namespace surfit
