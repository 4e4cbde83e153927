#pragma once

#include <algorithm>

#include "cost_functions/robust_kernel.h"
#include "surfit/core/lanes.h"

namespace surfit {

// Weighted sums of Jacobian rows, for all linearisations.
//
// A row [a r] has six derivatives by the left perturbation (w, v) and the residual r. A point
// has one to three rows and the information 1 / sigma^2. With s = information * sum r^2, the
// sums are rho(s), and products of columns with the weight information * rho'(s).
inline constexpr int kRowColumns = 7;
inline constexpr int kRowProducts = kRowColumns * (kRowColumns + 1) / 2;

// Sums over points. The last column and row of the products belong to the residual r.
struct RowSums {
  double product[kRowProducts] = {};  // upper triangle, row by row
  double rho = 0;

  RowSums& operator+=(const RowSums& other) {
    for (int k = 0; k < kRowProducts; ++k) product[k] += other.product[k];
    rho += other.rho;
    return *this;
  }
};

// Sum of all lanes in double precision.
template <typename V>
double SumOfLanes(const V& lanes) {
  double sum = 0;
  for (int k = 0; k < V::kCount; ++k) sum += static_cast<double>(lanes[k]);
  return sum;
}

// Partial sums per lane, with few terms to limit rounding errors.
template <typename V>
struct RowLanes {
  V product[kRowProducts];
  V rho;

  // Squared residual s and weight information * rho'(s) of a point.
  struct Weights {
    V s, weight;
  };
  // Adds the rows of one point per lane. Lanes without a point have information 0.
  template <int kRows>
  Weights Add(const V (&rows)[kRows][kRowColumns], const V& information,
              const RobustKernel& kernel) {
    KernelValue<V> value;
    const Weights weights = Weigh(rows, information, kernel, &value);
    for (int k = 0; k < kRows; ++k) AddProducts(rows[k], weights.weight);
    rho += value.rho;
    return weights;
  }

  // Weights of one point per lane, without adding its rows.
  template <int kRows>
  static Weights Weigh(const V (&rows)[kRows][kRowColumns], const V& information,
                       const RobustKernel& kernel, KernelValue<V>* value) {
    V s(0.);
    for (int k = 0; k < kRows; ++k) s += rows[k][kRowColumns - 1] * rows[k][kRowColumns - 1];
    s = s * information;
    *value = EvaluateKernel(kernel, s);
    return {s, information * value->slope};
  }

  // Adds the sums of all lanes.
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

// Iterates over the points [begin, end) in a fixed order. Each call of add(first, count, &sums)
// adds up to V::kCount points. Eight calls of `add` share one Sums, which is then passed to
// flush(sums).
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
