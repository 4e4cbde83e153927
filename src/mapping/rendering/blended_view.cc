#include "mapping/rendering/blended_view.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "mapping/map/view_frustum.h"
#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kThickness_m = 0.03f;  // depth range of one surface, in addition to the noise

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
  float weight = 0;
  float rho = 0;
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
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

  void Draw(const SurfelMap& map, const std::vector<DiscList>& lists, Layer layer) {
    ForEachPixel(lists, layer, [](Blend* pixel, const Disc&, float rho, float) {
      pixel->first = std::max(pixel->first, rho);
    });
    ForEachPixel(lists, layer, [&](Blend* pixel, const Disc& disc, float rho, float offset2) {
      if (rho >= BackOf(pixel->first)) Add(map, disc.surfel, rho, WeightAt(offset2), pixel);
    });
    for (Blend& pixel : pixels_) pixel.is_drawn = pixel.weight > 0;
  }

  void WriteTo(BlendedView* view) const {
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(v_begin_) * width_ + i;
      const Blend& pixel = pixels_[i];
      view->color[at] = pixel.is_drawn ? ToRgb8(pixel.color / pixel.weight) : Rgb8();
      view->depth_m[at] = pixel.is_drawn ? pixel.weight / pixel.rho : 0.f;
    }
  }

 private:
  float BackOf(float rho) const { return rho / (1.f + kThickness_m * rho + 4.f * sigma_ / rho); }

  static void Add(const SurfelMap& map, std::int32_t id, float rho, float weight, Blend* pixel) {
    const SurfelBlock& block = map.block(id / SurfelBlock::kCapacity);
    pixel->weight += weight;
    pixel->rho += weight * rho;
    pixel->color += weight * block.FineColor(id % SurfelBlock::kCapacity);
  }

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
    for (const auto* lists : {&splats, &fillers}) {
      canvas.Draw(map, *lists, kStable);
      canvas.Draw(map, *lists, kUnstable);
    }
    canvas.WriteTo(&view);
  });
  return view;
}

}  // namespace surfit
