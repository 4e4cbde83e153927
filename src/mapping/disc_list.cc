#include "mapping/disc_list.h"

#include <algorithm>

#include "mapping/bands.h"
#include "mapping/block_discs.h"
#include "mapping/clear_closely.h"
#include "mapping/fetch_block.h"
#include "surfit/core/lanes.h"

namespace surfit {
namespace {

// Returns a mask of the discs that may be seen.
std::uint64_t FindDiscs(const SurfelBlock& block, const PosedCamera& camera,
                        const RenderOptions& options, BlockDiscs* discs) {
  return WithInstructions([&](auto) {
    const std::uint64_t in_image = FindPixels(block, camera, options, discs) & ~block.at_edge;
    return in_image == 0 ? in_image : in_image & FindShapes(block, camera, options, discs);
  });
}

}  // namespace

void DiscLayer::Add(const Disc& disc) {
  const int number = static_cast<int>(discs.size()), last = (disc.v_end() - 1) / kBandRows;
  discs.push_back(disc);
  for (int band = disc.v_begin / kBandRows; band <= last; ++band) bands.Add(number, band);
}

void DiscList::Assign(const SurfelMap& map, const SurfelCell& cell, const PosedCamera& camera,
                      const ViewFrustum& frustum, const RenderOptions& options, int active_since) {
  for (DiscLayer& layer : layers_) {
    ClearClosely(cell.blocks.size() * SurfelBlock::kCapacity, &layer.discs);
    layer.bands.Clear(BandCount(camera.height));
  }
  BlockDiscs discs;
  for (std::size_t i = 0; i < cell.blocks.size(); ++i) {
    const std::int32_t b = cell.blocks[i];
    const SurfelBlock& block = map.block(b);
    FetchShapes(map.block(cell.blocks[std::min(i + 1, cell.blocks.size() - 1)]));
    if (!frustum.MaySee(block.bounds)) continue;
    const std::uint64_t seen =
        FindDiscs(block, camera, options, &discs) & MaskOfSeenSince(block, active_since);
    ForEachBit(seen, [&](int k) {
      const Layer layer = block.confidence[k] >= options.stable_confidence ? kStable : kUnstable;
      layers_[layer].Add(discs.Get(k, b * SurfelBlock::kCapacity + k));
    });
  }
}

}  // namespace surfit
