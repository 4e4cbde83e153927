#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

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

// Adds the sum of all lanes of lanes[k] to sums[k] for each k < kSums. Bitwise identical to
// SumOfLanes(). Transposes four vectors of eight lanes at a time, to add four sums at once.
template <int kSums, typename V>
void AddSumsOfLanes(const V* lanes, double* sums) {
  constexpr int kBatch = V::kCount == 8 ? kSums / 4 * 4 : 0;
  if constexpr (V::kCount == 8) {
    using Sums __attribute__((vector_size(32))) = double;
    for (int k = 0; k < kBatch; k += 4) {
      const auto &a = lanes[k].v, &b = lanes[k + 1].v, &c = lanes[k + 2].v, &d = lanes[k + 3].v;
      const auto ab = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
      const auto cd = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
      const auto ab_odd = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
      const auto cd_odd = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
      // Lanes i and 4 + i of a, b, c and d.
      const decltype(ab) pairs[] = {
          __builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 10, 11, 6, 7, 14, 15)};
      Sums sum = {};
      for (const auto& pair : pairs) {
        sum += __builtin_convertvector(__builtin_shufflevector(pair, pair, 0, 1, 2, 3), Sums);
      }
      for (const auto& pair : pairs) {
        sum += __builtin_convertvector(__builtin_shufflevector(pair, pair, 4, 5, 6, 7), Sums);
      }
      for (int i = 0; i < 4; ++i) sums[k + i] += sum[i];
    }
  }
  for (int k = kBatch; k < kSums; ++k) sums[k] += SumOfLanes(lanes[k]);
}

// Columns (i, j) of each product of a row.
inline constexpr auto kProductColumns = [] {
  std::array<std::pair<int, int>, kRowProducts> columns{};
  for (int i = 0, k = 0; i < kRowColumns; ++i) {
    for (int j = i; j < kRowColumns; ++j, ++k) columns[k].first = i, columns[k].second = j;
  }
  return columns;
}();

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
    AddSumsOfLanes<kRowProducts>(product, sums->product);
    sums->rho += SumOfLanes(rho);
  }

 private:
  void AddProducts(const V* row, const V& weight) {
    V weighted[kRowColumns];
    for (int i = 0; i < kRowColumns; ++i) weighted[i] = weight * row[i];
    AddProducts(row, weighted, std::make_index_sequence<kRowProducts>());
  }
  // The products are expanded at compile time: compilers do not unroll the triangular loop.
  template <std::size_t... k>
  void AddProducts(const V* row, const V* weighted, std::index_sequence<k...> /*products*/) {
    ((product[k] += weighted[kProductColumns[k].first] * row[kProductColumns[k].second]), ...);
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
