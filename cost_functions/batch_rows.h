#pragma once

#include "cost_functions/dual.h"
#include "cost_functions/pose.h"
#include "cost_functions/row_sums.h"

namespace surfit {

// Evaluates residuals r and rows [J r] of a functor (point_functor.h). J: Jacobian by the left
// perturbation (w, v), in the order of row_sums.h. V: SIMD type, one point per lane.
template <typename Functor, typename V>
class BatchRows {
 public:
  static constexpr int kRows = Functor::kResidualSize;
  using Rows = V[kRows][kRowColumns];

  // `pose`: pose block (pose.h). Keeps a reference to the functor.
  BatchRows(const Functor& functor, const double* pose) : functor_(functor) {
    for (int i = 0; i < kPoseSize; ++i) pose_[i] = V(pose[i]);
  }

  // Residuals at the pose. `data` has Functor::kDataSize values.
  void Residuals(const V* data, V* residuals) const {
    Dual<V, 3> moving[kRows];
    Evaluate(Moved(pose_, data), data, moving);
    for (int k = 0; k < kRows; ++k) residuals[k] = moving[k].value;
  }

  // With g = dr/dy and h = dr/dm the row is [y x g + m x h, g].
  void Linearize(const V* data, Rows& rows) const {
    const Moved moved(pose_, data);
    Dual<V, kVariables> residuals[kRows];
    Evaluate(moved, data, residuals);
    SetRows(moved, residuals, rows);
  }

  // Linearises at the identity, without rounding errors of y.
  static void LinearizeAtStart(const Functor& functor, const V* data, Rows& rows) {
    const Moved moved(data);
    Dual<V, kVariables> residuals[kRows];
    EvaluateAt(functor, moved, data, residuals);
    SetRows(moved, residuals, rows);
  }

 private:
  static constexpr bool kTurns = Functor::kTurned >= 0;
  static constexpr int kVariables = kTurns ? 6 : 3;  // y and, if used, m

  // y = R p + t as a rounded value and its rounding error `lost`. Computed as y = p + d,
  // because the motion d is small near the identity.
  struct Moved {
    Moved(const V* pose, const V* data) {
      TurnByPose(pose, data, lost);
      for (int i = 0; i < 3; ++i) {
        const V d = lost[i] + pose[4 + i];
        y[i] = data[i] + d;
        const V d_in_y = y[i] - data[i];
        lost[i] = (data[i] - (y[i] - d_in_y)) + (d - d_in_y);  // Knuth's exact sum of two
      }
      if constexpr (kTurns) RotateByPose(pose, data + Functor::kTurned, m);
    }
    explicit Moved(const V* data) {  // identity
      for (int i = 0; i < 3; ++i) {
        y[i] = data[i];
        if constexpr (kTurns) m[i] = data[Functor::kTurned + i];
      }
    }
    V y[3], lost[3];
    V m[kTurns ? 3 : 1];
  };

  static void SetRows(const Moved& moved, const Dual<V, kVariables>* residuals, Rows& rows) {
    for (int k = 0; k < kRows; ++k) {
      const V* gradient = residuals[k].derivative;
      Cross(moved.y, gradient, rows[k]);
      if constexpr (kTurns) {
        V turned[3];
        Cross(moved.m, gradient + 3, turned);
        for (int i = 0; i < 3; ++i) rows[k][i] += turned[i];
      }
      for (int i = 0; i < 3; ++i) rows[k][3 + i] = gradient[i];
      rows[k][kPoseTangentSize] = residuals[k].value;
    }
  }

  // Residuals with derivatives by y, and by m if N is 6. Adds the rounding error of y to first
  // order: residuals are often a thousand times smaller than coordinates.
  template <int N>
  void Evaluate(const Moved& moved, const V* data, Dual<V, N>* residuals) const {
    EvaluateAt(functor_, moved, data, residuals);
    for (int k = 0; k < kRows; ++k) {
      for (int i = 0; i < 3; ++i) residuals[k].value += residuals[k].derivative[i] * moved.lost[i];
    }
  }

  template <int N>
  static void EvaluateAt(const Functor& functor, const Moved& moved, const V* data,
                         Dual<V, N>* residuals) {
    Dual<V, N> y[3];
    for (int i = 0; i < 3; ++i) y[i] = Dual<V, N>::Variable(moved.y[i], i);
    if constexpr (N == 6) {
      Dual<V, N> m[3];
      for (int i = 0; i < 3; ++i) m[i] = Dual<V, N>::Variable(moved.m[i], 3 + i);
      functor.AtMovedPoint(y, m, data, residuals);
    } else if constexpr (kTurns) {
      functor.AtMovedPoint(y, moved.m, data, residuals);
    } else {
      functor.AtMovedPoint(y, data, residuals);
    }
  }

  const Functor& functor_;
  V pose_[kPoseSize];
};

}  // namespace surfit
