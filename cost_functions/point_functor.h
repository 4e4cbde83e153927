#pragma once

#include <array>

#include "cost_functions/pose.h"

namespace surfit {

// Base of functors of one source point p. The data, data[kDataSize], start with p. A functor
// defines residuals of the moved point y = R p + t, for scalars T and data D:
//   template <typename T, typename D> void AtMovedPoint(const T* y, const D* data, T* residuals)
// Residuals can also depend on a rotated vector m = R data[kTurned, kTurned + 3) with scalars M:
//   template <typename T, typename M, typename D>
//   void AtMovedPoint(const T* y, const M* m, const D* data, T* residuals)
// The code must not branch on T, M or D. It is used for single residual blocks
// (ceres::AutoDiffCostFunction, T = ceres::Jet, D = double) and for ReducedBatch (SIMD lanes of
// points).
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
