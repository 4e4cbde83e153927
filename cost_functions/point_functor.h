#pragma once

#include <array>

#include "cost_functions/pose.h"

namespace surfit {

// Base of functors of one source point p, stored in data[0] to data[2]. The parameter block is a
// pose (pose.h) with rotation R and translation t. A functor defines residuals of the moved point y
// = R p + t:
//   template <typename T, typename D> void AtMovedPoint(const T* y, const D* data, T* residuals)
// The residuals of functors with kTurned >= 0 also depend on a rotated vector m = R
// data[kTurned, kTurned + 3):
//   template <typename T, typename M, typename D>
//   void AtMovedPoint(const T* y, const M* m, const D* data, T* residuals)
// Must not branch on values: T, M and D are scalars, ceres::Jet (ceres::AutoDiffCostFunction),
// or SIMD types (ReducedBatch).
template <typename Derived, int kData, int kResiduals, int kTurnedData = -1>
struct PointFunctor {
  static constexpr int kDataSize = kData;
  static constexpr int kResidualSize = kResiduals;
  static constexpr int kTurned = kTurnedData;  // start of the rotated vector; negative: none

  std::array<double, kData> data = {};

  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    const auto& self = static_cast<const Derived&>(*this);
    T y[3];
    MovePoint(pose, data.data(), y);
    if constexpr (kTurned >= 0) {
      T m[3];
      RotateByPose(pose, data.data() + kTurned, m);
      self.AtMovedPoint(y, m, data.data(), residuals);
    } else {
      self.AtMovedPoint(y, data.data(), residuals);
    }
    return true;
  }

 protected:
  void Set(int first, const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) data[first + i] = v[i];
  }
};

}  // namespace surfit
