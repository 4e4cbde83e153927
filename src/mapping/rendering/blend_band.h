#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Blending weight (1 - offset2)^8. The added constant prevents a zero sum of weights.
inline float BlendWeight(float offset2) {
  const float a = 1.f - offset2, a2 = a * a, a4 = a2 * a2;
  return a4 * a4 + 1e-6f;
}

// Blend of a pixel.
struct Blend {
  float first = 0;  // inverse depth of the nearest surface; 0: none
  float back = 0;   // minimum inverse depth of the first surface
  float weight = 0;
  float rho = 0;
  int drawn_in = 0;  // number of the Draw() that drew the pixel; 0: none
};

// Offsets from a pixel to the centres of the splats of its first surface. The splats of a gap lie
// on all sides of the pixel, those of an edge on one side.
struct SplatSides {
  float u = 0, v = 0, length = 0;  // weighted sums of the offsets and of their lengths, px

  void Add(float du, float dv, float weight) {
    u += weight * du;
    v += weight * dv;
    length += weight * std::sqrt(du * du + dv * dv);
  }
  bool AreOne() const {
    constexpr float kOneSided = 0.75f;
    return u * u + v * v > kOneSided * kOneSided * length * length;
  }
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

  // Draws the pixels that no earlier call has drawn. Calls take(pixel, surfel, weight) for the
  // splats on the first surface of each pixel. `pixel`: index in the band.
  template <typename Take>
  void Draw(const std::vector<DiscList>& lists, Layer layer, const Take& take) {
    FindFirst(lists, layer);
    BlendFirst(lists, layer, take);
  }
  // Like Draw(), but leaves out pixels beyond an edge of the splats.
  template <typename Take>
  void FillGaps(const std::vector<DiscList>& lists, Layer layer, const Take& take) {
    FindFirst(lists, layer);
    LeaveOutEdges(lists, layer);
    BlendFirst(lists, layer, take);
  }

  // Calls take(pixel, surfel, share of the weight) for the pixels that the n-th Draw() drew. n: 1
  // for the first one. `lists` and `layer` must be those of this Draw().
  template <typename Take>
  void ForEachShare(const std::vector<DiscList>& lists, Layer layer, int n,
                    const Take& take) const {
    ForEachPixel(lists, layer, n, &pixels_,
                 [&](const Blend* pixel, const Disc& disc, float rho, float offset2) {
                   if (rho < pixel->back) return;
                   take(static_cast<std::int32_t>(pixel - pixels_.data()), disc.surfel,
                        BlendWeight(offset2) / pixel->weight);
                 });
  }

  int pixel_count() const { return static_cast<int>(pixels_.size()); }
  // Index of the first pixel in the image.
  std::size_t first_pixel() const { return static_cast<std::size_t>(v_begin_) * width_; }
  // 0: no splat.
  float WeightOf(int pixel) const { return pixels_[pixel].weight; }
  float Depth_m(int pixel) const {
    const Blend& blend = pixels_[pixel];
    return blend.drawn_in > 0 ? blend.weight / blend.rho : 0.f;
  }

 private:
  // Depth range of one surface, in addition to the noise.
  static constexpr float kThickness_m = 0.03f;

  void FindFirst(const std::vector<DiscList>& lists, Layer layer) {
    ForEachPixel(lists, layer, 0, &pixels_, [](Blend* pixel, const Disc&, float rho, float) {
      pixel->first = std::max(pixel->first, rho);
    });
    for (Blend& pixel : pixels_) pixel.back = pixel.first > 0 ? BackOf(pixel.first) : 0.f;
  }

  void LeaveOutEdges(const std::vector<DiscList>& lists, Layer layer) {
    std::vector<SplatSides> sides(pixels_.size());
    const auto add = [&](const Blend* pixel, const Disc& disc, float rho, float offset2) {
      if (rho < pixel->back) return;
      const int i = static_cast<int>(pixel - pixels_.data());
      const int u = i % width_, v = v_begin_ + i / width_;
      sides[i].Add(disc.u - static_cast<float>(u), disc.v - static_cast<float>(v), 1 - offset2);
    };
    ForEachPixel(lists, layer, 0, &pixels_, add);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      if (!sides[i].AreOne()) continue;
      pixels_[i].first = 0;
      pixels_[i].back = std::numeric_limits<float>::infinity();
    }
  }

  template <typename Take>
  void BlendFirst(const std::vector<DiscList>& lists, Layer layer, const Take& take) {
    ++draws_;
    const auto blend = [&](Blend* pixel, const Disc& disc, float rho, float offset2) {
      if (rho < pixel->back) return;
      const float weight = BlendWeight(offset2);
      pixel->weight += weight;
      pixel->rho += weight * rho;
      take(static_cast<std::int32_t>(pixel - pixels_.data()), disc.surfel, weight);
    };
    ForEachPixel(lists, layer, 0, &pixels_, blend);
    for (Blend& pixel : pixels_) {
      if (pixel.drawn_in == 0 && pixel.weight > 0) pixel.drawn_in = draws_;
    }
  }

  float BackOf(float rho) const { return rho / (1.f + kThickness_m * rho + 4.f * sigma_ / rho); }

  // Visits the pixels whose drawn_in has the given value. `Pixels`: vector of Blend or const.
  template <typename Pixels, typename F>
  void ForEachPixel(const std::vector<DiscList>& lists, Layer layer, int drawn_in, Pixels* pixels,
                    const F& f) const {
    for (const DiscList& list : lists) {
      const DiscLayer& in = list[layer];
      for (const int number : in.bands.In(band_)) {
        ForEachPixel(in.discs[number], drawn_in, pixels, f);
      }
    }
  }
  template <typename Pixels, typename F>
  void ForEachPixel(const Disc& disc, int drawn_in, Pixels* pixels, const F& f) const {
    const int begin = std::max<int>(v_begin_, disc.v_begin), end = std::min(v_end_, disc.v_end());
    for (int v = begin; v < end; ++v) {
      const float dv = static_cast<float>(v) - disc.v;
      auto* const row = &(*pixels)[static_cast<std::size_t>(v - v_begin_) * width_];
      for (int u = disc.u_begin; u < disc.u_end(); ++u) {
        if (row[u].drawn_in != drawn_in) continue;
        const float du = static_cast<float>(u) - disc.u;
        const float rho = disc.rho + disc.rho_u * du + disc.rho_v * dv;
        const float across2 = du * (disc.aa * du + disc.ab * dv) + disc.bb * dv * dv;
        if (rho > 0.f && across2 <= rho * rho) f(row + u, disc, rho, across2 / (rho * rho));
      }
    }
  }

  const int band_, v_begin_, v_end_, width_;
  const float sigma_;
  int draws_ = 0;
  std::vector<Blend> pixels_;
};

}  // namespace surfit
