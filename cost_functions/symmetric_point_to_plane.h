#pragma once

#include "cost_functions/point_functor.h"

namespace surfit {

// r = (R p + t - q) . (R m + n) / (2 sigma), one row: distance along the mean of source normal m
// and target normal n. (R, t) = target_from_source. As Rusinkiewicz 2019, but with the whole
// rotation applied to the source. It is 0 if both points are on a common plane, sphere or cylinder,
// so the convergence range is larger.
struct SymmetricPointToPlane : PointFunctor<SymmetricPointToPlane, 13, 1, 9> {
  SymmetricPointToPlane() = default;  // without data, for batches
  // p and its unit normal m in the source frame, q and n in the target frame; p, q and sigma in m.
  SymmetricPointToPlane(const Eigen::Vector3d& p, const Eigen::Vector3d& m,
                        const Eigen::Vector3d& q, const Eigen::Vector3d& n, double sigma_m) {
    Set(0, p);
    Set(3, q);
    Set(6, n);
    Set(9, m);
    data[12] = 1 / sigma_m;
  }

  template <typename T, typename M, typename D>
  void AtMovedPoint(const T* y, const M* m, const D* d, T* residuals) const {
    residuals[0] = ((y[0] - d[3]) * (m[0] + d[6]) + (y[1] - d[4]) * (m[1] + d[7]) +
                    (y[2] - d[5]) * (m[2] + d[8])) *
                   (d[12] * 0.5);
  }
};

}  // namespace surfit
