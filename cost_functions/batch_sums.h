#pragma once

#include <algorithm>
#include <type_traits>

#include "cost_functions/batch_data.h"
#include "cost_functions/batch_rows.h"
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

// Adds the points [begin, end) of a batch to sums: lanes of short sums in precision S, which are
// then added in double.
template <typename V, bool kWithJacobian, typename Functor, typename S>
class BatchSummer {
 public:
  BatchSummer(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
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
  return ParallelSum(
      0, static_cast<int>(data.size()), kPointsPerBlock, BatchSums(), [&](int begin, int end) {
        return WithInstructions([&](auto instructions) {
          using V = Lanes<S, decltype(instructions)>;
          return BatchSummer<V, kWithJacobian, Functor, S>(functor, data, pose, kernel)
              .Sum(begin, end);
        });
      });
}

}  // namespace surfit
