#pragma once

#include <vector>

#include "surfit/registration/normal_system.h"

namespace surfit {

// The associated pairs of one image row in single precision, as structure of arrays that stay in
// the first-level cache. Padded, so that whole lanes may be read past size.
struct PairBuffer {
  static constexpr int kLanes = 8;

  explicit PairBuffer(int capacity) {
    for (auto* array : {&px, &py, &pz, &qx, &qy, &qz, &nx, &ny, &nz, &information, &weight}) {
      array->assign(capacity + kLanes, 0.f);
    }
  }

  std::vector<float> px, py, pz;   // source point in the target frame
  std::vector<float> qx, qy, qz;   // target point
  std::vector<float> nx, ny, nz;   // target normal
  std::vector<float> information;  // 1 / sigma^2, in 1/m^2
  std::vector<float> weight;       // times the robust kernel's
  int size = 0;
  int inlier_count = 0;
};

// Adds the rows [p x n, n | n . (q - p)] of the pairs to the system: lanes of single precision,
// summed into double precision every few lanes in a fixed order. Overwrites the padding.
void AddPairs(PairBuffer* pairs, NormalSystem* system);

}  // namespace surfit
