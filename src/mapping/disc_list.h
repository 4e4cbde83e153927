#pragma once

#include "mapping/bands.h"
#include "mapping/bucket_list.h"
#include "mapping/disc.h"
#include "mapping/posed_camera.h"
#include "surfit/mapping/model_renderer.h"

namespace surfit {

// Unstable discs are drawn only where no stable ones are.
enum Layer { kStable, kUnstable, kLayerCount };

// The discs that a camera may see of a part of a map, sorted by layer and band, and there by
// surfel. A disc on the border of two bands is there in both.
class DiscList {
 public:
  static constexpr int kCapacity = 2048;  // surfels

  // Takes the discs of the surfels [begin, end), at most kCapacity of them.
  void Assign(const SurfelMap& map, int begin, int end, const PosedCamera& camera,
              const RenderOptions& options);

  BucketList<Disc>::Span In(Layer layer, int band) const {
    return discs_.In(layer * band_count_ + band);
  }

 private:
  int band_count_ = 0;
  BucketList<Disc> discs_;
};

}  // namespace surfit
