#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "mapping/rendering/band_canvas.h"
#include "mapping/rendering/bands.h"
#include "surfit/core/lanes.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Blending weight (1 - offset2)^8. The added constant prevents a zero sum of weights.
inline float BlendWeight(float offset2) {
  const float a = 1.f - offset2, a2 = a * a, a4 = a2 * a2;
  return a4 * a4 + 1e-6f;
}

// Sums of the splats on the first surface of a pixel.
struct Blend {
  float weight = 0;
  float rho = 0;     // weighted inverse depth
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
        pixels_(static_cast<std::size_t>(v_end_ - v_begin_) * camera.width),
        open_(DrawnIn(0)),
        first_(open_.size(), 0.f),
        back_(open_.size(), 0.f) {}

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
    ForEachPixel(lists, layer, DrawnIn(n), [&](int pixel, const Disc& disc, float, float offset2) {
      take(pixel, disc.surfel, BlendWeight(offset2) / pixels_[pixel].weight);
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
    float* first = first_.data();
    const int width = width_;
    ForEachEight(lists, layer, open_, [&](const Disc&, int pixel, auto met, auto rho, auto) {
      using Numbers = decltype(rho);
      const Numbers before = Numbers::LoadHalves(first + pixel, first + pixel + width);
      Select(Numbers::Both(met, rho > before), rho, before)
          .StoreHalves(first + pixel, first + pixel + width);
    });
    for (int i = 0; i < pixel_count(); ++i) back_[i] = first_[i] > 0 ? BackOf(first_[i]) : 0.f;
  }

  void LeaveOutEdges(const std::vector<DiscList>& lists, Layer layer) {
    std::vector<SplatSides> sides(pixels_.size());
    ForEachPixel(lists, layer, open_, [&](int pixel, const Disc& disc, float, float offset2) {
      const int u = pixel % width_, v = v_begin_ + pixel / width_;
      sides[pixel].Add(disc.u - static_cast<float>(u), disc.v - static_cast<float>(v), 1 - offset2);
    });
    for (int i = 0; i < pixel_count(); ++i) {
      if (!sides[i].AreOne()) continue;
      first_[i] = 0;
      back_[i] = std::numeric_limits<float>::infinity();
    }
  }

  template <typename Take>
  void BlendFirst(const std::vector<DiscList>& lists, Layer layer, const Take& take) {
    ++draws_;
    ForEachPixel(lists, layer, open_, [&](int pixel, const Disc& disc, float rho, float offset2) {
      const float weight = BlendWeight(offset2);
      pixels_[pixel].weight += weight;
      pixels_[pixel].rho += weight * rho;
      take(pixel, disc.surfel, weight);
    });
    for (int i = 0; i < pixel_count(); ++i) {
      if (pixels_[i].drawn_in > 0 || !(pixels_[i].weight > 0)) continue;
      pixels_[i].drawn_in = draws_;
      open_[i] = 0;
    }
  }

  float BackOf(float rho) const { return rho / (1.f + kThickness_m * rho + 4.f * sigma_ / rho); }

  // Per pixel: 1 if the n-th Draw() drew it, otherwise 0. n = 0: not drawn. Vector code reads a row
  // and seven values more.
  std::vector<float> DrawnIn(int n) const {
    std::vector<float> drawn(pixels_.size() + width_ + 7, 0.f);
    for (int i = 0; i < pixel_count(); ++i) drawn[i] = pixels_[i].drawn_in == n ? 1.f : 0.f;
    return drawn;
  }

  // Calls f(pixel, disc, inverse depth, offset2) for the splats on the first surfaces of the wanted
  // pixels.
  template <typename F>
  void ForEachPixel(const std::vector<DiscList>& lists, Layer layer,
                    const std::vector<float>& wanted, const F& f) const {
    const float* back = back_.data();
    const int width = width_;
    ForEachEight(
        lists, layer, wanted, [&](const Disc& disc, int pixel, auto met, auto rho, auto across2) {
          using Numbers = decltype(rho);
          const auto in_front =
              Numbers::Both(met, rho >= Numbers::LoadHalves(back + pixel, back + pixel + width));
          if (!Numbers::Any(in_front)) return;
          float rhos[Numbers::kCount], offset2[Numbers::kCount];
          Select(in_front, rho, Numbers(0.f)).Store(rhos);
          (across2 / (rho * rho)).Store(offset2);
          for (int k = 0; k < Numbers::kCount; ++k) {
            if (!(rhos[k] > 0)) continue;
            f(pixel + k % 4 + k / 4 * width, disc, rhos[k], offset2[k]);
          }
        });
  }

  // Calls f(disc, pixel, met, rho, across2), see ForEachEightPixels(). `met` has only wanted
  // pixels.
  template <typename F>
  void ForEachEight(const std::vector<DiscList>& lists, Layer layer,
                    const std::vector<float>& wanted, const F& f) const {
    const float* at = wanted.data();
    const int width = width_, v_begin = v_begin_, v_end = v_end_;
    WithInstructions([&](auto instructions) {
      using Instructions = decltype(instructions);
      using Numbers = Lanes<float, Instructions>;
      const auto is_wanted = [&](int u, int v) {
        const float* first = at + (v - v_begin) * width + u;
        return Numbers::LoadHalves(first, first + width) > Numbers(0.f);
      };
      for (const DiscList& list : lists) {
        const DiscLayer& in = list[layer];
        for (const int number : in.bands.In(band_)) {
          const Disc& disc = in.discs[number];
          ForEachEightPixels<Instructions>(
              disc, std::max<int>(v_begin, disc.v_begin), std::min(v_end, disc.v_end()),
              [&](int u, int v) { return Numbers::Any(is_wanted(u, v)); },
              [&](int u, int v, const auto& met, const Numbers& rho, const Numbers& across2) {
                f(disc, (v - v_begin) * width + u, Numbers::Both(met, is_wanted(u, v)), rho,
                  across2);
              });
        }
      }
    });
  }

  const int band_, v_begin_, v_end_, width_;
  const float sigma_;
  int draws_ = 0;
  std::vector<Blend> pixels_;
  std::vector<float> open_;   // DrawnIn(0)
  std::vector<float> first_;  // inverse depth of the nearest surface; 0: none
  std::vector<float> back_;   // minimum inverse depth of the first surface
};

}  // namespace surfit
