#include "mapping/rendering/blended_view.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "mapping/map/view_frustum.h"
#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/blend_band.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kMinShare = 0.02f;  // smaller shares of a pixel are dropped

constexpr Layer kLayers[] = {kStable, kUnstable};  // in the order of drawing

constexpr int kMaxHalfWindow_px = 127;  // a disc stores its size in 8 bits

RenderOptions SplatOptions(float radius_ratio) {
  RenderOptions options;
  options.radius_ratio = radius_ratio;
  options.max_half_window_px = kMaxHalfWindow_px;
  return options;
}

std::vector<DiscList> FindSplats(const SurfelMap& map, const PosedCamera& camera,
                                 const RenderOptions& options) {
  const ViewFrustum frustum(camera, static_cast<float>(options.max_half_window_px));
  const std::vector<std::int32_t> cells = VisibleCells(map, frustum);
  std::vector<DiscList> lists(cells.size());
  ParallelFor(0, static_cast<int>(cells.size()), 1, [&](int i, int) {
    lists[i].Assign(map, map.cell(cells[i]), camera, frustum, options,
                    std::numeric_limits<int>::min());
  });
  return lists;
}

// Draws one band of the view.
void DrawBand(const SurfelMap& map, const std::vector<DiscList>& splats,
              const std::vector<DiscList>& fillers, BlendBand* band, BlendedView* view) {
  std::vector<Eigen::Vector3f> colors(band->pixel_count(), Eigen::Vector3f::Zero());
  const auto take = [&](std::int32_t pixel, std::int32_t id, float weight) {
    const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
    colors[pixel] += weight * block.FineColor(id % SurfelBlock::kCapacity);
  };
  for (const Layer layer : kLayers) band->Draw(splats, layer, take);
  for (const Layer layer : kLayers) band->FillGaps(fillers, layer, take);
  for (int i = 0; i < band->pixel_count(); ++i) {
    const float weight = band->WeightOf(i);
    view->color[band->first_pixel() + i] = weight > 0 ? ToRgb8(colors[i] / weight) : Rgb8();
    view->depth_m[band->first_pixel() + i] = band->Depth_m(i);
  }
}

}  // namespace

BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view) {
  const PosedCamera camera(sensor.camera, world_from_view);
  const std::vector<DiscList> splats = FindSplats(map, camera, SplatOptions(2));
  const std::vector<DiscList> fillers = FindSplats(map, camera, SplatOptions(4));
  BlendedView view = {Image<Rgb8>(camera.width, camera.height),
                      Image<float>(camera.width, camera.height)};
  ParallelFor(0, BandCount(camera.height), 1, [&](int band, int) {
    BlendBand canvas(band, sensor.camera, sensor.noise);
    DrawBand(map, splats, fillers, &canvas, &view);
  });
  return view;
}

struct BlendedDepth::Bands {
  std::vector<DiscList> splats;
  std::vector<BlendBand> drawn;
};

BlendedDepth::BlendedDepth(const SurfelMap& map, const DepthSensor& sensor,
                           const Rigid3d& world_from_view)
    : depth_m_(sensor.camera.width, sensor.camera.height) {
  auto bands = std::make_unique<Bands>();
  {
    // Repeated allocations of this size in several threads make each heap of the allocator grow.
    const ThreadLimit one_heap(1);
    bands->splats = FindSplats(map, PosedCamera(sensor.camera, world_from_view), SplatOptions(2));
  }
  const int count = BandCount(sensor.camera.height);
  bands->drawn.reserve(count);
  for (int i = 0; i < count; ++i) bands->drawn.emplace_back(i, sensor.camera, sensor.noise);
  ParallelFor(0, count, 1, [&](int i, int) {
    BlendBand& band = bands->drawn[i];
    for (const Layer layer : kLayers) {
      band.Draw(bands->splats, layer, [](std::int32_t, std::int32_t, float) {});
    }
    for (int k = 0; k < band.pixel_count(); ++k) {
      depth_m_[band.first_pixel() + k] = band.Depth_m(k);
    }
  });
  bands_ = std::move(bands);
}

BlendedDepth::~BlendedDepth() = default;

std::vector<BlendShare> BlendedDepth::SharesOf(int band) const {
  std::vector<BlendShare> shares;
  const BlendBand& drawn = bands_->drawn[band];
  int n = 0;
  for (const Layer layer : kLayers) {
    const auto keep = [&](std::int32_t pixel, std::int32_t surfel, float share) {
      if (share < kMinShare) return;
      shares.push_back({surfel, static_cast<std::int32_t>(drawn.first_pixel()) + pixel, share});
    };
    drawn.ForEachShare(bands_->splats, layer, ++n, keep);
  }
  return shares;
}

}  // namespace surfit
