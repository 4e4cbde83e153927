#pragma once

#include "cost_functions/point_functor.h"

namespace surfit {

// r = (R p + t - q) / sigma, three rows: difference to the corresponding point (Besl and McKay
// 1992). (R, t) = target_from_source.
struct PointToPoint : PointFunctor<PointToPoint, 7, 3> {
  PointToPoint() = default;  // without data, for batches
  // p in the source frame, q in the target frame; p, q and sigma in m.
  PointToPoint(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double sigma_m) {
    Set(0, p);
    Set(3, q);
    data[6] = 1 / sigma_m;
  }

  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    for (int i = 0; i < 3; ++i) residuals[i] = (y[i] - d[3 + i]) * d[6];
  }
};

}  // namespace surfit
