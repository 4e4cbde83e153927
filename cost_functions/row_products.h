#pragma once

#include "surfit/core/lanes.h"

namespace surfit {

// Rows [a r]: six derivatives by the left increment and the residual.
inline constexpr int kRowColumns = 7;
inline constexpr int kRowProducts = kRowColumns * (kRowColumns + 1) / 2;

// Weighted sums of the products of the columns of many rows, one sum a lane: the upper triangle,
// row by row.
template <typename V>
struct RowProducts {
  V product[kRowProducts];

  void Add(const V* row, const V& weight) {
    for (int i = 0, k = 0; i < kRowColumns; ++i) {
      const V weighted = weight * row[i];
      for (int j = i; j < kRowColumns; ++j, ++k) product[k] += weighted * row[j];
    }
  }
};

template <typename V>
double SumOfLanes(const V& lanes) {
  double sum = 0;
  for (int k = 0; k < V::kCount; ++k) sum += static_cast<double>(lanes[k]);
  return sum;
}

}  // namespace surfit
