#include "mapping/fusion/frame_observations.h"

#include <algorithm>

#include "mapping/map/block_lanes.h"
#include "mapping/rendering/bands.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kPixelsSoon = 24;

// Looks up surfel colours in batches. Add() number i sets the colour of `first`[i].
class ColorsOfSurfels {
 public:
  // `first`: array with one observation per Add(). The caller must not reallocate the array.
  ColorsOfSurfels(const FrameColors& colors, SurfelObservation* first)
      : colors_(colors), next_(first) {}

  void Add(const Patch& surfel) {
    batch_.Add({surfel.x, surfel.y, surfel.z}, {surfel.nx, surfel.ny, surfel.nz});
    if (batch_.count == ColorBatch::kCapacity) Flush();
  }

  void Flush() {
    colors_.LookUp(&batch_);
    for (int k = 0; k < batch_.count; ++k, ++next_) {
      const SeenColor seen = batch_.Seen(k);
      next_->color = seen.color;
      next_->color_weight = seen.weight;
    }
    batch_.count = 0;
  }

 private:
  const FrameColors& colors_;
  SurfelObservation* next_;
  ColorBatch batch_;
};

}  // namespace

FrameObservations::Counts FrameObservations::Gather(
    const RgbdFrame& frame, const FrameColors& colors, const std::vector<MeasuredPoint>& points,
    const Image<float>& weights, const PosedCamera& camera, const SurfelAssignment& choice) {
  const int width = camera.width;
  const bool has_color = !frame.color.empty();
  int beside[9];  // index offsets of the 3 x 3 neighbourhood, row by row
  for (int k = 0; k < 9; ++k) beside[k] = (k / 3 - 1) * width + k % 3 - 1;
  in_band_.resize(BandCount(camera.height));
  return ParallelSum(0, camera.height, kBandRows, Counts(), [&](int begin, int end) {
    Counts counts;
    std::vector<SurfelObservation>& seen = in_band_[begin / kBandRows];
    seen.clear();
    // Prevents reallocation, because `surfel_colors` points into `seen`.
    seen.reserve(static_cast<std::size_t>(kBandRows) * width);
    ColorsOfSurfels surfel_colors(colors, seen.data());
    std::vector<std::uint16_t> choosing(width);
    for (int v = begin; v < end; ++v) {
      choice.AssignmentsOfRow(v, choosing.data());
      for (int u = 0; u < width; ++u) {
        const int soon = std::min(u + kPixelsSoon, width - 1);
        if (choosing[soon] != 0) __builtin_prefetch(choice.OfPixel(v * width + soon));
        if (choosing[u] == 0) continue;  // no point is assigned to the surfel of this pixel
        Candidate* const candidate = choice.OfPixel(v * width + u);
        PointAverage sum(FusionOptions::kMaxRadiusRatio * candidate->radius_m);
        ForEachBit(choosing[u], [&](int k) {
          const int pixel = v * width + u + beside[k];
          sum.Add(points[pixel], weights[pixel]);
          ++counts.points;
        });
        ++counts.surfels;
        seen.push_back(sum.Observation(camera));
        candidate->seen = &seen.back();
        if (has_color) surfel_colors.Add(candidate->patch);
      }
    }
    if (has_color) surfel_colors.Flush();
    return counts;
  });
}

}  // namespace surfit
