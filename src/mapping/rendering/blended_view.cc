#include "mapping/rendering/blended_view.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "mapping/map/view_frustum.h"
#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kThickness_m = 0.03f;  // depth range of one surface, in addition to the noise

constexpr float kMinShare = 0.02f;  // smaller shares of a pixel are dropped

constexpr int kMaxHalfWindow_px = 127;  // a disc stores its size in 8 bits

RenderOptions SplatOptions(float radius_ratio) {
  RenderOptions options;
  options.radius_ratio = radius_ratio;
  options.max_half_window_px = kMaxHalfWindow_px;
  return options;
}

// Blending weight (1 - offset2)^8. The added constant prevents a zero sum of weights.
float WeightAt(float offset2) {
  const float a = 1.f - offset2, a2 = a * a, a4 = a2 * a2;
  return a4 * a4 + 1e-6f;
}

struct Blend {
  float first = 0;  // inverse depth of the nearest surface; 0: none
  float back = 0;   // minimum inverse depth of the first surface
  float weight = 0;
  float rho = 0;
  bool is_drawn = false;
};

// Blends the splats of one image band, in the order of their surfels.
class BlendBand {
 public:
  BlendBand(int band, const PinholeCamera& camera, const DepthNoise& noise)
      : band_(band),
        v_begin_(band * kBandRows),
        v_end_(std::min(camera.height, v_begin_ + kBandRows)),
        width_(camera.width),
        sigma_(static_cast<float>(noise.inverse_depth_sigma)),
        pixels_(static_cast<std::size_t>(v_end_ - v_begin_) * camera.width) {}

  // Calls take(pixel, surfel, weight) for the splats on the first surface of each pixel. `pixel`:
  // index in the band.
  template <typename Take>
  void Draw(const std::vector<DiscList>& lists, Layer layer, const Take& take) {
    ForEachPixel(lists, layer, [](Blend* pixel, const Disc&, float rho, float) {
      pixel->first = std::max(pixel->first, rho);
    });
    for (Blend& pixel : pixels_) pixel.back = pixel.first > 0 ? BackOf(pixel.first) : 0.f;
    ForEachPixel(lists, layer, [&](Blend* pixel, const Disc& disc, float rho, float offset2) {
      if (rho < pixel->back) return;
      const float weight = WeightAt(offset2);
      pixel->weight += weight;
      pixel->rho += weight * rho;
      take(static_cast<std::int32_t>(pixel - pixels_.data()), disc.surfel, weight);
    });
    for (Blend& pixel : pixels_) pixel.is_drawn = pixel.weight > 0;
  }

  int pixel_count() const { return static_cast<int>(pixels_.size()); }
  // Index of the first pixel in the image.
  std::size_t first_pixel() const { return static_cast<std::size_t>(v_begin_) * width_; }
  // 0: no splat.
  float WeightOf(int pixel) const { return pixels_[pixel].weight; }
  float Depth_m(int pixel) const {
    const Blend& blend = pixels_[pixel];
    return blend.is_drawn ? blend.weight / blend.rho : 0.f;
  }

 private:
  float BackOf(float rho) const { return rho / (1.f + kThickness_m * rho + 4.f * sigma_ / rho); }

  template <typename F>
  void ForEachPixel(const std::vector<DiscList>& lists, Layer layer, const F& f) {
    for (const DiscList& list : lists) {
      const DiscLayer& in = list[layer];
      for (const int number : in.bands.In(band_)) ForEachPixel(in.discs[number], f);
    }
  }
  template <typename F>
  void ForEachPixel(const Disc& disc, const F& f) {
    const int begin = std::max<int>(v_begin_, disc.v_begin), end = std::min(v_end_, disc.v_end());
    for (int v = begin; v < end; ++v) {
      const float dv = static_cast<float>(v) - disc.v;
      Blend* const row = &pixels_[static_cast<std::size_t>(v - v_begin_) * width_];
      for (int u = disc.u_begin; u < disc.u_end(); ++u) {
        if (row[u].is_drawn) continue;
        const float du = static_cast<float>(u) - disc.u;
        const float rho = disc.rho + disc.rho_u * du + disc.rho_v * dv;
        const float across2 = du * (disc.aa * du + disc.ab * dv) + disc.bb * dv * dv;
        if (rho > 0.f && across2 <= rho * rho) f(row + u, disc, rho, across2 / (rho * rho));
      }
    }
  }

  const int band_, v_begin_, v_end_, width_;
  const float sigma_;
  std::vector<Blend> pixels_;
};

std::vector<DiscList> Splats(const SurfelMap& map, const PosedCamera& camera,
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
  for (const auto* lists : {&splats, &fillers}) {
    for (const Layer layer : {kStable, kUnstable}) {
      band->Draw(*lists, layer, [&](std::int32_t pixel, std::int32_t id, float weight) {
        const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
        colors[pixel] += weight * block.FineColor(id % SurfelBlock::kCapacity);
      });
    }
  }
  for (int i = 0; i < band->pixel_count(); ++i) {
    const float weight = band->WeightOf(i);
    view->color[band->first_pixel() + i] = weight > 0 ? ToRgb8(colors[i] / weight) : Rgb8();
    view->depth_m[band->first_pixel() + i] = band->Depth_m(i);
  }
}

struct Hit {
  std::int32_t pixel;  // index in the band
  BlendShares::Share share;
};

// Writes the shares of a band, sorted by pixel. Drops small shares.
void WriteBand(const BlendBand& band, const std::vector<Hit>& hits, BlendShares* shares) {
  const auto share_of = [&](const Hit& hit) { return hit.share.weight / band.WeightOf(hit.pixel); };
  std::vector<std::uint32_t> next(band.pixel_count() + 1, 0);
  for (const Hit& hit : hits) {
    if (share_of(hit) >= kMinShare) ++next[hit.pixel + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  shares->first = next;
  shares->shares.resize(next.back());
  for (const Hit& hit : hits) {
    if (share_of(hit) < kMinShare) continue;
    shares->shares[next[hit.pixel]++] = {hit.share.surfel, share_of(hit)};
  }
  shares->depth_m.resize(band.pixel_count());
  for (int i = 0; i < band.pixel_count(); ++i) shares->depth_m[i] = band.Depth_m(i);
}

}  // namespace

BlendedView DrawBlended(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view) {
  const PosedCamera camera(sensor.camera, world_from_view);
  const std::vector<DiscList> splats = Splats(map, camera, SplatOptions(2));
  const std::vector<DiscList> fillers = Splats(map, camera, SplatOptions(4));
  BlendedView view = {Image<Rgb8>(camera.width, camera.height),
                      Image<float>(camera.width, camera.height)};
  ParallelFor(0, BandCount(camera.height), 1, [&](int band, int) {
    BlendBand canvas(band, sensor.camera, sensor.noise);
    DrawBand(map, splats, fillers, &canvas, &view);
  });
  return view;
}

std::vector<BlendShares> FindBlendShares(const SurfelMap& map, const DepthSensor& sensor,
                                         const Rigid3d& world_from_view) {
  const PosedCamera camera(sensor.camera, world_from_view);
  const std::vector<DiscList> splats = Splats(map, camera, SplatOptions(2));
  std::vector<BlendShares> bands(BandCount(camera.height));
  ParallelFor(0, BandCount(camera.height), 1, [&](int band, int) {
    BlendBand canvas(band, sensor.camera, sensor.noise);
    std::vector<Hit> hits;
    for (const Layer layer : {kStable, kUnstable}) {
      canvas.Draw(splats, layer, [&](std::int32_t pixel, std::int32_t surfel, float weight) {
        hits.push_back({pixel, {surfel, weight}});
      });
    }
    WriteBand(canvas, hits, &bands[band]);
  });
  return bands;
}

}  // namespace surfit
