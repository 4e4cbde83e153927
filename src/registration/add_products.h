#pragma once

#include "cost_functions/row_products.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Adds the sums over lanes of weighted rows [a r]: a a^T to the Hessian, -r a to the right side and
// r^2 to the square sum.
template <typename V>
void AddProducts(const RowProducts<V>& products, Matrix6d* hessian, Vector6d* right_side,
                 double* square_sum) {
  for (int i = 0, k = 0; i < kRowColumns; ++i) {
    for (int j = i; j < kRowColumns; ++j, ++k) {
      const double sum = SumOfLanes(products.product[k]);
      if (i == 6) {
        *square_sum += sum;
      } else if (j == 6) {
        (*right_side)[i] -= sum;
      } else {
        (*hessian)(i, j) += sum;
        if (i != j) (*hessian)(j, i) += sum;
      }
    }
  }
}

}  // namespace surfit
