#pragma once

#include <vector>

#include "mapping/disc.h"
#include "mapping/surfel_projection.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

// The image is drawn in bands of so many rows.
constexpr int kBandRows = 16;
inline int BandCount(int height) { return (height + kBandRows - 1) / kBandRows; }

// Unstable discs are drawn only where no stable ones are.
enum Layer { kStable, kUnstable, kLayerCount };

// The discs that a camera may see of a part of a map, sorted by layer and band, and there by
// surfel. A disc on the border of two bands is there in both.
class DiscList {
 public:
  static constexpr int kCapacity = 2048;  // surfels

  struct Span {
    const Disc *first, *last;
    const Disc* begin() const { return first; }
    const Disc* end() const { return last; }
  };

  // Takes the discs of the surfels [begin, end), at most kCapacity of them.
  void Assign(const SurfelMap& map, int begin, int end, const PosedCamera& camera,
              const RenderOptions& options);

  Span In(Layer layer, int band) const {
    const int bucket = layer * band_count_ + band;
    return {discs_.data() + begin_[bucket], discs_.data() + begin_[bucket + 1]};
  }

 private:
  struct Unsorted;

  void Sort(const Unsorted& unsorted);

  int band_count_ = 0;
  std::vector<Disc> discs_;
  std::vector<int> begin_;  // of each bucket (a layer's part in a band), and the end of the last
};

}  // namespace surfit
