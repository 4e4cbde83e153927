#pragma once

#include <array>

#include "cost_functions/pose.h"

namespace surfit {

// What functors on one source point p have in common. Their numbers, data[kDataSize], start with p.
// A functor defines its residuals once, on numbers T (with derivatives) and data D, either of the
// moved point y = R p + t,
//   template <typename T, typename D> void AtMovedPoint(const T* y, const D* data, T* residuals)
// or, if they depend on the pose in other ways, of the pose block (see pose.h),
//   template <typename T, typename D> void AtPose(const T* pose, const D* data, T* residuals)
// without branches on T or D, and serves then both one residual block per point
// (ceres::AutoDiffCostFunction, T = ceres::Jet, D = double) and ReducedBatch (lanes of points).
template <typename Derived, int kData, int kResiduals>
struct PointFunctor {
  static constexpr int kDataSize = kData;
  static constexpr int kResidualSize = kResiduals;

  std::array<double, kData> data = {};

  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    static_cast<const Derived*>(this)->AtPose(pose, data.data(), residuals);
    return true;
  }

  template <typename T, typename D>
  void AtPose(const T* pose, const D* numbers, T* residuals) const {
    T y[3];
    MovePoint(pose, numbers, y);
    static_cast<const Derived*>(this)->AtMovedPoint(y, numbers, residuals);
  }

 protected:
  void Set(int first, const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) data[first + i] = v[i];
  }
};

}  // namespace surfit
