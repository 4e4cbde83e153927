#include "mapping/disc_list.h"

#include <glog/logging.h>

#include "mapping/disc_projector.h"

namespace surfit {

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
  Disc discs[kCapacity];
  Layer layers[kCapacity];
  int count = 0;
  const DiscProjector projector(map, camera, options);
  FourDiscs four;
  for (int i = begin; i < end; i += 4) {
    if (!projector.Project(i, end, &four)) continue;
    for (int k = 0; k < 4; ++k) {
      if (!four.seen[k] || map.at_edge[i + k]) continue;
      Disc& disc = discs[count];
      disc = four[k];
      disc.surfel = i + k;
      const Rgb8 color = map.Color(i + k);
      disc.red = color.r;
      disc.green = color.g;
      disc.blue = color.b;
      const bool stable = map.confidence[i + k] >= options.stable_confidence;
      layers[count++] = stable ? kStable : kUnstable;
    }
  }
  discs_.Assign(discs, count, kLayerCount * band_count_, [&](int k, const auto& f) {
    ForEachBand(discs[k], [&](int band) { f(layers[k] * band_count_ + band); });
  });
}

}  // namespace surfit
