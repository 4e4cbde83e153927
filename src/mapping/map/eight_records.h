#pragma once

#include "surfit/core/lanes.h"

namespace surfit {

// Transposes eight records of eight floats to eight vectors and back: lane j of columns[i] is
// records[j][i]. Vectors combine halves of the records k and k + 4, so no shuffle crosses the
// 128-bit halves. Reads and writes all eight floats of each record. Records need no alignment.
template <typename Instructions>
class EightRecords {
 public:
  using V = Lanes<float, Instructions>;
  static_assert(V::kCount == 8);

  // Loads or stores all eight records.
  static void Load(const float* const (&records)[8], V (&columns)[8]) {
    for (int half = 0; half < 2; ++half) {
      V rows[4];
      for (int k = 0; k < 4; ++k) {
        rows[k] = V::LoadHalves(records[k] + 4 * half, records[k + 4] + 4 * half);
      }
      TransposeHalves(rows, &columns[4 * half]);
    }
  }

  static void Store(const V (&columns)[8], float* const (&records)[8]) {
    for (int half = 0; half < 2; ++half) {
      V rows[4];
      const V* of_half = &columns[4 * half];
      const V four[4] = {of_half[0], of_half[1], of_half[2], of_half[3]};
      TransposeHalves(four, rows);
      for (int k = 0; k < 4; ++k) {
        rows[k].StoreHalves(records[k] + 4 * half, records[k + 4] + 4 * half);
      }
    }
  }

 private:
  static void TransposeHalves(const V (&a)[4], V* b) {
    const V low01 = __builtin_shufflevector(a[0].v, a[1].v, 0, 8, 1, 9, 4, 12, 5, 13);
    const V high01 = __builtin_shufflevector(a[0].v, a[1].v, 2, 10, 3, 11, 6, 14, 7, 15);
    const V low23 = __builtin_shufflevector(a[2].v, a[3].v, 0, 8, 1, 9, 4, 12, 5, 13);
    const V high23 = __builtin_shufflevector(a[2].v, a[3].v, 2, 10, 3, 11, 6, 14, 7, 15);
    b[0] = __builtin_shufflevector(low01.v, low23.v, 0, 1, 8, 9, 4, 5, 12, 13);
    b[1] = __builtin_shufflevector(low01.v, low23.v, 2, 3, 10, 11, 6, 7, 14, 15);
    b[2] = __builtin_shufflevector(high01.v, high23.v, 0, 1, 8, 9, 4, 5, 12, 13);
    b[3] = __builtin_shufflevector(high01.v, high23.v, 2, 3, 10, 11, 6, 7, 14, 15);
  }
};

}  // namespace surfit
