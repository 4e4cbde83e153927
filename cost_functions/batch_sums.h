#pragma once

#include "cost_functions/batch_data.h"
#include "cost_functions/batch_rows.h"
#include "cost_functions/row_sums.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Sums over the rows of the points [begin, end) of a batch (BatchRows), as defined in row_sums.h.
// Residuals are in standard deviations, so the information is 1. Keeps references to functor and
// data.
template <typename V, typename Functor, typename S>
class BatchSummer {
 public:
  BatchSummer(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
              const RobustKernel& kernel)
      : functor_(functor), rows_(functor, pose), data_(data), kernel_(kernel) {}

  // Sums at the pose.
  RowSums Sum(int begin, int end) const {
    return SumBy(begin, end, [&](const V* data, auto& rows) { rows_.Linearize(data, rows); });
  }

  // Sums at the identity pose.
  RowSums SumAtStart(int begin, int end) const {
    return SumBy(begin, end, [&](const V* data, auto& rows) {
      BatchRows<Functor, V>::LinearizeAtStart(functor_, data, rows);
    });
  }

  // Sum of rho(s): twice the cost.
  double Rho(int begin, int end) const {
    double sum = 0;
    SumByLanes<V, V>(
        begin, end,
        [&](int first, int count, V* rho) {
          V data[Functor::kDataSize], residuals[Functor::kResidualSize], s(0.);
          Load(first, count, data);
          rows_.Residuals(data, residuals);
          for (const V& residual : residuals) s += residual * residual;
          *rho += EvaluateKernel(kernel_, s).rho.UpTo(count);
        },
        [&](const V& rho) { sum += SumOfLanes(rho); });
    return sum;
  }

 private:
  template <typename SetRows>
  RowSums SumBy(int begin, int end, const SetRows& set_rows) const {
    RowSums sums;
    SumByLanes<V, RowLanes<V>>(
        begin, end,
        [&](int first, int count, RowLanes<V>* lanes) {
          V data[Functor::kDataSize];
          Load(first, count, data);
          typename BatchRows<Functor, V>::Rows rows;
          set_rows(data, rows);
          lanes->Add(rows, V(1.).UpTo(count), kernel_);
        },
        [&](const RowLanes<V>& lanes) { lanes.AddTo(&sums); });
    return sums;
  }

  void Load(int first, int count, V* data) const {
    for (int i = 0; i < Functor::kDataSize; ++i) {
      data[i] = V::LoadUpTo(data_.array(i) + first, count);
    }
  }

  const Functor& functor_;
  const BatchRows<Functor, V> rows_;
  const BatchData<Functor, S>& data_;
  const RobustKernel kernel_;
};

// Adds up sum(summer, begin, end) over blocks of a batch, in parallel. The result does not
// depend on the number of threads.
template <typename Sum, typename Functor, typename S, typename F>
Sum SumBatch(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
             const RobustKernel& kernel, const F& sum) {
  constexpr int kBlockPoints = 4096;
  return ParallelSum(
      0, static_cast<int>(data.size()), kBlockPoints, Sum(), [&](int begin, int end) {
        return WithInstructions([&](auto instructions) {
          using V = Lanes<S, decltype(instructions)>;
          return sum(BatchSummer<V, Functor, S>(functor, data, pose, kernel), begin, end);
        });
      });
}

// Sums over all points at a pose block (pose.h).
template <typename Functor, typename S>
RowSums SumRows(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
                const RobustKernel& kernel) {
  return SumBatch<RowSums>(functor, data, pose, kernel, [](const auto& summer, int begin, int end) {
    return summer.Sum(begin, end);
  });
}

// Like SumRows() at the identity, without rounding errors of the moved points.
template <typename Functor, typename S>
RowSums SumRowsAtStart(const Functor& functor, const BatchData<Functor, S>& data,
                       const RobustKernel& kernel) {
  return SumBatch<RowSums>(
      functor, data, kIdentityBlock, kernel,
      [](const auto& summer, int begin, int end) { return summer.SumAtStart(begin, end); });
}

// Sum of rho(s) over all points at a pose block: twice the cost.
template <typename Functor, typename S>
double SumRho(const Functor& functor, const BatchData<Functor, S>& data, const double* pose,
              const RobustKernel& kernel) {
  return SumBatch<double>(functor, data, pose, kernel, [](const auto& summer, int begin, int end) {
    return summer.Rho(begin, end);
  });
}

}  // namespace surfit
