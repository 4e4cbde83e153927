#include "mapping/sightings.h"

#include <algorithm>

#include "mapping/bands.h"
#include "mapping/block_lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// So many pixels ahead a candidate is asked for, to be in the cache by then.
constexpr int kPixelsSoon = 24;

}  // namespace

Sightings::Counts Sightings::Gather(const RgbdFrame& frame, const FrameColors& colors,
                                    const std::vector<MeasuredPoint>& points,
                                    const Image<float>& weights, const PosedCamera& camera,
                                    const SurfelChoice& choice) {
  const int width = camera.width;
  const bool has_color = !frame.color.empty();
  const auto average = [&](const Candidate& candidate, std::uint32_t choosing) {
    PointAverage sum(max_radius_ratio_ * candidate.radius_m);
    ForEachBit(choosing, [&](int k) {
      const int pixel = candidate.pixel + (k / 3 - 1) * width + k % 3 - 1;
      sum.Add(points[pixel], weights[pixel]);
    });
    SurfelObservation seen = sum.Observation(camera);
    if (has_color) {
      const Patch& patch = candidate.patch;
      const SeenColor color =
          colors.At({patch.x, patch.y, patch.z}, {patch.nx, patch.ny, patch.nz});
      seen.color = color.color;
      seen.color_weight = color.weight;
    }
    return seen;
  };
  in_band_.resize(BandCount(camera.height));
  return ParallelSum(0, camera.height, kBandRows, Counts(), [&](int begin, int end) {
    Counts counts;
    std::vector<SurfelObservation>& seen = in_band_[begin / kBandRows];
    seen.clear();
    seen.reserve(static_cast<std::size_t>(kBandRows) * width);  // so that none is moved
    for (int pixel = begin * width; pixel < end * width; ++pixel) {
      __builtin_prefetch(choice.OfPixel(std::min(pixel + kPixelsSoon, end * width - 1)));
      Candidate* const candidate = choice.OfPixel(pixel);
      if (!candidate) continue;
      const std::uint32_t choosing = choice.Choosing(pixel);
      if (choosing == 0) continue;  // its own point is nearer to a neighbour's surfel
      seen.push_back(average(*candidate, choosing));
      candidate->seen = &seen.back();
      counts.points += __builtin_popcount(choosing);
      ++counts.surfels;
    }
    return counts;
  });
}

}  // namespace surfit
