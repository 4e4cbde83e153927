#pragma once

#include <ceres/cost_function.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cost_functions/batch_sums.h"
#include "cost_functions/pose_manifold.h"

namespace surfit {

// Cost function over one pose block that is reduced to the sums of its rows.
class ReducedBlock : public ceres::CostFunction {
 public:
  // Computes the sums over all rows at the identity, and caches them for Evaluate(). Optional. Must
  // not run at the same time as Evaluate(). The result is valid until the next call.
  virtual const RowSums& Prepare() = 0;
};

// Ceres residual block of N points, reduced to seven rows. One functor (point_functor.h) is
// evaluated with the data of each point.
//
// The residual rows are the triangular factor [R q; 0 e] of all rows [J r]. It satisfies R^T R =
// J^T J, R^T q = J^T r and |q|^2 + e^2 = |r|^2. Cost, gradient, Gauss-Newton matrix and
// Levenberg-Marquardt steps equal those of all rows. With a robust kernel, rows have the weight
// rho'(s), and |q|^2 + e^2 = sum rho(s), with s = |r|^2 per point. The factor is a Cholesky
// decomposition of sums of products, computed by SIMD autodiff.
//
// S: precision of residuals and products; sums are double. The errors of cost and gradient are
// 1e-5 (float) or 1e-9 (double) of the sum of absolute terms. Evaluation is parallel and bitwise
// identical for any number of threads.
//
// The parameter block is a pose (pose.h) on LeftPoseManifold or ProductPoseManifold. Do not add
// a loss function, because it would apply to the sum. Evaluate() returns false if the cost
// is not finite. Without Jacobians, the residuals are (sqrt(sum rho(s)), 0, ..., 0). Only their
// norm then equals the norm of the residuals with Jacobians.
template <typename Functor, typename S = float>
class ReducedBatch final : public ReducedBlock {
 public:
  ReducedBatch(Functor functor, BatchData<Functor, S> data, const RobustKernel& kernel)
      : functor_(std::move(functor)), data_(std::move(data)), kernel_(kernel) {
    mutable_parameter_block_sizes()->push_back(kPoseSize);
    set_num_residuals(kRows);
  }

  const RowSums& Prepare() override {
    prepared_ = SumRowsAtStart(functor_, data_, kernel_);
    return *prepared_;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* pose = parameters[0];
    const bool is_prepared = prepared_ && std::equal(pose, pose + kPoseSize, kIdentityBlock);
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      std::fill(residuals, residuals + kRows, 0.);
      residuals[0] =
          std::sqrt(is_prepared ? prepared_->rho : SumRho(functor_, data_, pose, kernel_));
      return std::isfinite(residuals[0]);
    }
    const RowSums sums = is_prepared ? *prepared_ : SumRows(functor_, data_, pose, kernel_);
    if (!std::isfinite(sums.rho)) return false;
    Factor factor;
    Decompose(sums, &factor, residuals);
    Eigen::Matrix<double, kPoseTangentSize, kPoseSize, Eigen::RowMajor> minus;
    LeftPoseManifold().MinusJacobian(pose, minus.data());
    Eigen::Map<Eigen::Matrix<double, kRows, kPoseSize, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian = factor * minus;
    return true;
  }

 private:
  static constexpr int kRows = kRowColumns;
  using Factor = Eigen::Matrix<double, kRows, kPoseTangentSize>;

  // Cholesky decomposition of the semidefinite matrix of products: R as factor, [q e] as
  // residuals. Pivots are at least the rounding error of the sums. R^T q = J^T r stays valid.
  static void Decompose(const RowSums& sums, Factor* factor, double* residuals) {
    constexpr double kPrecision = sizeof(S) == sizeof(float) ? 1e-6 : 1e-13;
    Eigen::Matrix<double, kRows, kRows> rest;  // upper triangle
    for (int i = 0, k = 0; i < kRows; ++i) {
      for (int j = i; j < kRows; ++j, ++k) rest(i, j) = sums.product[k];
    }
    const Eigen::Matrix<double, kRows, 1> diagonal = rest.diagonal();
    factor->setZero();
    double explained = 0;
    for (int i = 0; i < kPoseTangentSize; ++i) {
      residuals[i] = 0;
      if (!(diagonal[i] > 0)) continue;
      const double pivot = std::sqrt(std::max(rest(i, i), kPrecision * diagonal[i]));
      Eigen::Matrix<double, kRows, 1> row = Eigen::Matrix<double, kRows, 1>::Zero();
      row[i] = pivot;
      for (int j = i + 1; j < kRows; ++j) row[j] = rest(i, j) / pivot;
      for (int a = i + 1; a < kRows; ++a) {
        for (int b = a; b < kRows; ++b) rest(a, b) -= row[a] * row[b];
      }
      factor->row(i) = row.head<kPoseTangentSize>().transpose();
      residuals[i] = row[kPoseTangentSize];
      explained += residuals[i] * residuals[i];
    }
    residuals[kRows - 1] = std::sqrt(std::max(0., sums.rho - explained));
  }

  Functor functor_;
  BatchData<Functor, S> data_;
  RobustKernel kernel_;
  std::optional<RowSums> prepared_;
};

}  // namespace surfit
