#pragma once

#include <vector>

#include "mapping/merge_gate.h"

namespace surfit {

// A row of patches as structure of arrays, to do several at once. It goes beyond the image on
// either side, by one patch, and to the right by as many as are done at once. Where there is none
// its normal and radius are zero, so that no gate lets it pass.
class PatchRow {
 public:
  explicit PatchRow(int width) : stride_(width + 9), numbers_(kNumbers * stride_, 0.f) {}

  // u from 0 to width - 1.
  void Set(int u, const Patch& patch, float radius_m, float confidence) {
    const float values[kNumbers] = {patch.x,  patch.y,  patch.z,  patch.nx,
                                    patch.ny, patch.nz, radius_m, confidence};
    for (int i = 0; i < kNumbers; ++i) numbers_[i * stride_ + u + 1] = values[i];
  }

  // Those from u >= -1 on.
  template <typename Numbers>
  PatchOf<Numbers> Patches(int u) const {
    return {Load<Numbers>(0, u), Load<Numbers>(1, u), Load<Numbers>(2, u),
            Load<Numbers>(3, u), Load<Numbers>(4, u), Load<Numbers>(5, u)};
  }
  template <typename Numbers>
  Numbers Radii(int u) const {
    return Load<Numbers>(6, u);
  }
  template <typename Numbers>
  Numbers Confidences(int u) const {
    return Load<Numbers>(7, u);
  }

 private:
  template <typename Numbers>
  Numbers Load(int i, int u) const {
    return Numbers::Load(&numbers_[i * stride_ + u + 1]);
  }

  static constexpr int kNumbers = 8;

  const int stride_;
  std::vector<float> numbers_;
};

}  // namespace surfit
