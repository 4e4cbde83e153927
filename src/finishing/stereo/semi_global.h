#pragma once

#include <cstddef>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Costs of all labels for some pixels of an image. 255 is the cost of a mismatch.
class CostVolume {
 public:
  static constexpr int kLabels = 128;
  static constexpr std::int32_t kNone = -1;

  // `pixels`: not 0 for pixels with costs. The costs are unspecified.
  explicit CostVolume(const Image<std::uint8_t>& pixels);

  int width() const { return index_.width(); }
  int height() const { return index_.height(); }
  std::size_t pixel_count() const { return costs_.size() / kLabels; }
  // Place of a pixel in the volume, or kNone.
  std::int32_t IndexOf(int u, int v) const { return index_(u, v); }
  std::uint8_t* Costs(std::int32_t index) { return &costs_[Offset(index)]; }
  const std::uint8_t* Costs(std::int32_t index) const { return &costs_[Offset(index)]; }

 private:
  static std::size_t Offset(std::int32_t index) {
    return static_cast<std::size_t>(index) * kLabels;
  }

  Image<std::int32_t> index_;
  RawVector<std::uint8_t> costs_;
};

// Semi-global matching (Hirschmueller 2008) with 8 paths. The cost of a path is
//   L(p, d) = C(p, d) + min(L(q, d), L(q, d -+ 1) + P1, min_k L(q, k) + P2) - min_k L(q, k)
// for the pixel p, its predecessor q and the label d. A path begins behind pixels without costs. P2
// is smaller at edges of `intensity`. Returns the label with the least sum over all paths, with the
// vertex of a parabola as fraction. -1: pixel without costs. `intensity` has the size of the image.
// Single-threaded.
Image<float> BestLabels(const CostVolume& volume, const Image<std::uint8_t>& intensity);

}  // namespace surfit
