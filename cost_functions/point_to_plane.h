#pragma once

#include "cost_functions/point_functor.h"

namespace surfit {

// r = n . (R p + t - q) / sigma, one row: distance to the plane through q with the unit normal n
// (Chen and Medioni 1992). (R, t) = target_from_source.
struct PointToPlane : PointFunctor<PointToPlane, 10, 1> {
  PointToPlane() = default;  // without data, for batches
  // p in the source frame, q and n in the target frame; p, q and sigma in m.
  PointToPlane(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
               double sigma_m) {
    Set(0, p);
    Set(3, q);
    Set(6, n);
    data[9] = 1 / sigma_m;
  }

  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    residuals[0] = ((y[0] - d[3]) * d[6] + (y[1] - d[4]) * d[7] + (y[2] - d[5]) * d[8]) * d[9];
  }
};

}  // namespace surfit
