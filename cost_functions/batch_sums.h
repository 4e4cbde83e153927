#pragma once

#include <algorithm>
#include <type_traits>

#include "cost_functions/batch_data.h"
#include "cost_functions/dual.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "cost_functions/row_products.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Sums over the rows [J r] of a batch, J by the left increment (w, v): of products of their columns
// weighted by rho', and of rho.
struct BatchSums {
  double product[kRowProducts] = {};  // see RowProducts
  double rho = 0;

  BatchSums& operator+=(const BatchSums& other) {
    for (int k = 0; k < kRowProducts; ++k) product[k] += other.product[k];
    rho += other.rho;
    return *this;
  }
};

// Whether a functor's residuals depend on the pose through y = R p + t alone.
template <typename Functor, typename V, typename = void>
struct UsesMovedPointOnly : std::false_type {};
template <typename Functor, typename V>
struct UsesMovedPointOnly<
    Functor, V,
    std::void_t<decltype(std::declval<const Functor&>().AtMovedPoint(
        std::declval<const V*>(), std::declval<const V*>(), std::declval<V*>()))>>
    : std::true_type {};

// A pose block and its derivatives by the left increment.
struct MovingPose {
  explicit MovingPose(const double* block) {
    std::copy_n(block, kPoseSize, pose);
    LeftPoseManifold().PlusJacobian(block, plus_jacobian);
  }
  double pose[kPoseSize];
  double plus_jacobian[kPoseSize * kPoseTangentSize];
};

// Evaluates a functor and its Jacobian for as many points at once as the lanes V hold.
template <typename Functor, typename V>
class BatchRows {
 public:
  static constexpr int kRows = Functor::kResidualSize;
  using Rows = V[kRows][kRowColumns];

  BatchRows(const Functor& functor, const MovingPose& pose) : functor_(functor) {
    for (int i = 0; i < kPoseSize; ++i) {
      pose_[i] = V(pose.pose[i]);
      moving_pose_[i] = Moving(pose_[i]);
      for (int j = 0; j < kPoseTangentSize; ++j) {
        moving_pose_[i].derivative[j] = V(pose.plus_jacobian[i * kPoseTangentSize + j]);
      }
    }
  }

  void Residuals(const V* data, V* residuals) const {
    if constexpr (UsesMovedPointOnly<Functor, V>::value) {
      Dual<V, 3> moving[kRows];
      AtMovedPoint(MovedPoint(pose_, data), data, moving);
      for (int k = 0; k < kRows; ++k) residuals[k] = moving[k].value;
    } else {
      functor_.AtPose(pose_, data, residuals);
    }
  }

  void Linearize(const V* data, Rows& rows) const {
    if constexpr (UsesMovedPointOnly<Functor, V>::value) {
      LinearizeAtMovedPoint(data, rows);
    } else {
      Moving residuals[kRows];
      functor_.AtPose(moving_pose_, data, residuals);
      for (int k = 0; k < kRows; ++k) {
        for (int j = 0; j < kPoseTangentSize; ++j) rows[k][j] = residuals[k].derivative[j];
        rows[k][kPoseTangentSize] = residuals[k].value;
      }
    }
  }

 private:
  using Moving = Dual<V, kPoseTangentSize>;

  // y = R p + t = p + d as its rounded value and what that lost: the moves d of a pose near the
  // identity are small, and so is their rounding beside that of y.
  struct MovedPoint {
    MovedPoint(const V* pose, const V* p) {
      TurnByPose(pose, p, lost);
      for (int i = 0; i < 3; ++i) {
        const V d = lost[i] + pose[4 + i];
        y[i] = p[i] + d;
        const V d_in_y = y[i] - p[i];
        lost[i] = (p[i] - (y[i] - d_in_y)) + (d - d_in_y);  // Knuth's exact sum of two
      }
    }
    V y[3], lost[3];
  };

  // Residuals and their derivatives g by y. To first order what y lost counts as well: residuals
  // are often differences a thousand times smaller than the points.
  void AtMovedPoint(const MovedPoint& point, const V* data, Dual<V, 3>* residuals) const {
    Dual<V, 3> moving_y[3];
    for (int i = 0; i < 3; ++i) moving_y[i] = Dual<V, 3>::Variable(point.y[i], i);
    functor_.AtMovedPoint(moving_y, data, residuals);
    for (int k = 0; k < kRows; ++k) {
      for (int i = 0; i < 3; ++i) {
        residuals[k].value += residuals[k].derivative[i] * point.lost[i];
      }
    }
  }

  // y moves to y + w x y + v, so that with g = dr/dy the row is [y x g, g].
  void LinearizeAtMovedPoint(const V* data, Rows& rows) const {
    const MovedPoint point(pose_, data);
    Dual<V, 3> residuals[kRows];
    AtMovedPoint(point, data, residuals);
    for (int k = 0; k < kRows; ++k) {
      Cross(point.y, residuals[k].derivative, rows[k]);
      for (int i = 0; i < 3; ++i) rows[k][3 + i] = residuals[k].derivative[i];
      rows[k][kPoseTangentSize] = residuals[k].value;
    }
  }

  const Functor& functor_;
  V pose_[kPoseSize];
  Moving moving_pose_[kPoseSize];
};

// Adds the points [begin, end) of a batch to sums: lanes of short sums in precision S, which are
// then added in double.
template <typename V, bool kWithJacobian, typename Functor, typename S>
class BatchSummer {
 public:
  BatchSummer(const Functor& functor, const BatchData<Functor, S>& data, const MovingPose& pose,
              const RobustKernel& kernel)
      : rows_(functor, pose), data_(data), kernel_(kernel) {}

  BatchSums Sum(int begin, int end) const {
    constexpr int kFlush = 8 * V::kCount;
    BatchSums sums;
    for (int first = begin; first < end; first += kFlush) {
      LaneSums lanes;
      const int last = std::min(end, first + kFlush);
      for (int i = first; i < last; i += V::kCount) Add(i, last - i, &lanes);
      Flush(lanes, &sums);
    }
    return sums;
  }

 private:
  static constexpr int kRows = Functor::kResidualSize;
  struct LaneSums {
    std::conditional_t<kWithJacobian, RowProducts<V>, char> products;
    V rho;
  };

  void Add(int first, int count, LaneSums* sums) const {
    V data[Functor::kDataSize];
    for (int i = 0; i < Functor::kDataSize; ++i) {
      data[i] = V::LoadUpTo(data_.array(i) + first, count);
    }
    V s(0.);
    if constexpr (kWithJacobian) {
      typename BatchRows<Functor, V>::Rows rows;
      rows_.Linearize(data, rows);
      for (int k = 0; k < kRows; ++k) s += rows[k][kPoseTangentSize] * rows[k][kPoseTangentSize];
      const KernelValue<V> kernel = Masked(EvaluateKernel(kernel_, s), count);
      sums->rho += kernel.rho;
      for (int k = 0; k < kRows; ++k) sums->products.Add(rows[k], kernel.slope);
    } else {
      V residuals[kRows];
      rows_.Residuals(data, residuals);
      for (int k = 0; k < kRows; ++k) s += residuals[k] * residuals[k];
      sums->rho += Masked(EvaluateKernel(kernel_, s), count).rho;
    }
  }

  static KernelValue<V> Masked(const KernelValue<V>& kernel, int count) {
    return {kernel.rho.UpTo(count), kernel.slope.UpTo(count)};
  }

  static void Flush(const LaneSums& lanes, BatchSums* sums) {
    if constexpr (kWithJacobian) {
      for (int k = 0; k < kRowProducts; ++k) {
        sums->product[k] += SumOfLanes(lanes.products.product[k]);
      }
    }
    sums->rho += SumOfLanes(lanes.rho);
  }

  const BatchRows<Functor, V> rows_;
  const BatchData<Functor, S>& data_;
  const RobustKernel kernel_;
};

// The sums of a whole batch at a pose block, the same at any number of threads.
template <bool kWithJacobian, typename Functor, typename S>
BatchSums SumBatch(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
                   const RobustKernel& kernel) {
  constexpr int kPointsPerBlock = 4096;
  const MovingPose moving_pose(pose);
  return ParallelSum(
      0, static_cast<int>(data.size()), kPointsPerBlock, BatchSums(), [&](int begin, int end) {
        return WithInstructions([&](auto instructions) {
          using V = Lanes<S, decltype(instructions)>;
          return BatchSummer<V, kWithJacobian, Functor, S>(functor, data, moving_pose, kernel)
              .Sum(begin, end);
        });
      });
}

}  // namespace surfit
