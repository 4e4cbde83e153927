#pragma once

#include <algorithm>

#include "cost_functions/robust_kernel.h"
#include "surfit/core/lanes.h"

namespace surfit {

// The kernel of linearisation, for all that is summed over points, whoever makes their rows.
//
// A point has rows [a r]: six derivatives by the left increment (w, v), and the residual. With the
// information 1 / sigma^2 of a point and s = information * sum r^2 over its rows, products of the
// columns are summed with the weight information * rho'(s), and so is rho(s).
inline constexpr int kRowColumns = 7;
inline constexpr int kRowProducts = kRowColumns * (kRowColumns + 1) / 2;

// Weighted sums of the products of columns, and of rho(s).
struct RowSums {
  double product[kRowProducts] = {};  // of the columns: the upper triangle, row by row
  double rho = 0;

  RowSums& operator+=(const RowSums& other) {
    for (int k = 0; k < kRowProducts; ++k) product[k] += other.product[k];
    rho += other.rho;
    return *this;
  }
};

template <typename V>
double SumOfLanes(const V& lanes) {
  double sum = 0;
  for (int k = 0; k < V::kCount; ++k) sum += static_cast<double>(lanes[k]);
  return sum;
}

// Short sums, one a lane.
template <typename V>
struct RowLanes {
  V product[kRowProducts];
  V rho;

  // What each point's rows were weighted with: s, and information * rho'(s).
  struct Weights {
    V s, weight;
  };
  // Adds the rows of as many points as there are lanes; information is 0 where there is no point.
  template <int kRows>
  Weights Add(const V (&rows)[kRows][kRowColumns], const V& information,
              const RobustKernel& kernel) {
    KernelValue<V> value;
    const Weights weights = Weigh(rows, information, kernel, &value);
    for (int k = 0; k < kRows; ++k) AddProducts(rows[k], weights.weight);
    rho += value.rho;
    return weights;
  }

  // Adds nothing.
  template <int kRows>
  static Weights Weigh(const V (&rows)[kRows][kRowColumns], const V& information,
                       const RobustKernel& kernel, KernelValue<V>* value) {
    V s(0.);
    for (int k = 0; k < kRows; ++k) s += rows[k][kRowColumns - 1] * rows[k][kRowColumns - 1];
    s = s * information;
    *value = EvaluateKernel(kernel, s);
    return {s, information * value->slope};
  }

  void AddTo(RowSums* sums) const {
    for (int k = 0; k < kRowProducts; ++k) sums->product[k] += SumOfLanes(product[k]);
    sums->rho += SumOfLanes(rho);
  }

 private:
  void AddProducts(const V* row, const V& weight) {
    for (int i = 0, k = 0; i < kRowColumns; ++i) {
      const V weighted = weight * row[i];
      for (int j = i; j < kRowColumns; ++j, ++k) product[k] += weighted * row[j];
    }
  }
};

// Walks through the points [begin, end) by lanes V: add(first, count, &sums) adds up to V::kCount
// of them to new Sums, from which flush(sums) takes what at most eight calls have added, so that
// sums in single precision stay short. In a fixed order.
template <typename V, typename Sums, typename Add, typename Flush>
void SumByLanes(int begin, int end, const Add& add, const Flush& flush) {
  constexpr int kFlush = 8 * V::kCount;
  for (int first = begin; first < end; first += kFlush) {
    Sums sums;
    const int last = std::min(end, first + kFlush);
    for (int i = first; i < last; i += V::kCount) add(i, last - i, &sums);
    flush(sums);
  }
}

}  // namespace surfit
