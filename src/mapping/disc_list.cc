#include "mapping/disc_list.h"

#include <glog/logging.h>

#include "mapping/disc_projector.h"

namespace surfit {

struct DiscList::Unsorted {
  int size = 0;
  Disc discs[kCapacity];
  Layer layers[kCapacity];
};

namespace {

// Calls f(band) for the bands that a disc lies in.
template <typename F>
void ForEachBand(const Disc& disc, const F& f) {
  const int last = (disc.v_end - 1) / kBandRows;
  for (int band = disc.v_begin / kBandRows; band <= last; ++band) f(band);
}

}  // namespace

void DiscList::Assign(const SurfelMap& map, int begin, int end, const PosedCamera& camera,
                      const RenderOptions& options) {
  CHECK_LE(end - begin, kCapacity);
  band_count_ = BandCount(camera.height);
  Unsorted unsorted;
  const DiscProjector projector(map, camera, options);
  FourDiscs four;
  for (int i = begin; i < end; i += 4) {
    if (!projector.Project(i, end, &four)) continue;
    for (int k = 0; k < 4; ++k) {
      if (!four.seen[k] || map.at_edge[i + k]) continue;
      Disc& disc = unsorted.discs[unsorted.size];
      disc = four[k];
      disc.surfel = i + k;
      const Rgb8 color = map.Color(i + k);
      disc.red = color.r;
      disc.green = color.g;
      disc.blue = color.b;
      const bool stable = map.confidence[i + k] >= options.stable_confidence;
      unsorted.layers[unsorted.size++] = stable ? kStable : kUnstable;
    }
  }
  Sort(unsorted);
}

// A counting sort.
void DiscList::Sort(const Unsorted& unsorted) {
  begin_.assign(kLayerCount * band_count_ + 1, 0);
  for (int k = 0; k < unsorted.size; ++k) {
    ForEachBand(unsorted.discs[k],
                [&](int band) { ++begin_[unsorted.layers[k] * band_count_ + band]; });
  }
  int count = 0;
  for (int& bucket : begin_) {
    count += bucket;
    bucket = count;
  }
  const std::size_t size = static_cast<std::size_t>(count);
  if (discs_.capacity() < size || discs_.capacity() > 2 * size) {
    discs_ = std::vector<Disc>(size);  // just that: not twice as much, nor what was needed once
  } else {
    discs_.resize(size);
  }
  for (int k = unsorted.size - 1; k >= 0; --k) {
    ForEachBand(unsorted.discs[k], [&](int band) {
      discs_[--begin_[unsorted.layers[k] * band_count_ + band]] = unsorted.discs[k];
    });
  }
}

}  // namespace surfit
