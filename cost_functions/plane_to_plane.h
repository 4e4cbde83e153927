#pragma once

#include <Eigen/Cholesky>

#include "cost_functions/point_functor.h"

namespace surfit {

// Generalized-ICP residual (Segal, Haehnel and Thrun 2009): r = U (R p + t - q), three rows, with
// U^T U = C^-1 and (R, t) = target_from_source. C = C_q + R C_p R^T is the covariance of the
// difference of two points on planes. As in the paper, C is constant during a solve. So the sum of
// squares changes between two solves, and its minimum is not the end of the iteration. Solvers that
// take different steps end with sums that can differ by 1e-3 of the sum.
struct PlaneToPlane : PointFunctor<PlaneToPlane, 12, 3> {
  PlaneToPlane() = default;  // without data, for batches
  // p in the source frame, q in the target frame, m. Covariance C in the target frame, m^2,
  // positive definite.
  PlaneToPlane(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
               const Eigen::Matrix3d& covariance) {
    Set(0, p);
    Set(3, q);
    // C^-1 = L L^T, so U is L^T.
    const Eigen::Matrix3d inverse = covariance.inverse();
    const Eigen::Matrix3d u = inverse.llt().matrixU();
    data[6] = u(0, 0), data[7] = u(0, 1), data[8] = u(0, 2);
    data[9] = u(1, 1), data[10] = u(1, 2), data[11] = u(2, 2);
  }

  // Covariance of a point on a plane, m^2: standard deviation sigma_m along the unit normal, and
  // sigma_m / flatness within the plane. `flatness` must be positive.
  static Eigen::Matrix3d CovarianceOfPlane(const Eigen::Vector3d& normal, double sigma_m,
                                           double flatness) {
    const Eigen::Matrix3d across = normal * normal.transpose();
    const double within = sigma_m / flatness;
    return sigma_m * sigma_m * across + within * within * (Eigen::Matrix3d::Identity() - across);
  }

  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    const T x[3] = {y[0] - d[3], y[1] - d[4], y[2] - d[5]};
    residuals[0] = x[0] * d[6] + x[1] * d[7] + x[2] * d[8];
    residuals[1] = x[1] * d[9] + x[2] * d[10];
    residuals[2] = x[2] * d[11];
  }
};

}  // namespace surfit
