#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "surfit/core/image.h"
#include "surfit/core/lanes.h"

namespace surfit {

// Inverse depth, times a scale, of some rows of a depth image and of a margin around them on all
// sides: wide enough that neither windows nor whole lanes leave it. Missing pixels and what lies
// outside the image are kMissing, so far from all inverse depths that no difference with it passes
// for one on a surface: what computes on windows needs no branch for them.
class InverseDepthBand {
 public:
  static constexpr float kMissing = -1e30f;

  // Room for `rows` rows of an image of this width, and the margin (px).
  InverseDepthBand(int width, int rows, int margin)
      : width_(width),
        margin_(margin),
        stride_((width + kLanes - 1) / kLanes * kLanes + 2 * margin),
        values_(new float[static_cast<std::size_t>(rows + 2 * margin) * stride_]) {}

  // Takes the rows [begin, end) of a depth image (m, 0 = missing).
  template <typename V>
  void Fill(const Image<float>& depth_m, int begin, int end, float scale) {
    first_ = begin - margin_;
    for (int v = first_; v < end + margin_; ++v) {
      float* const out = values_.get() + (v - first_) * stride_;
      if (v < 0 || v >= depth_m.height()) {
        std::fill_n(out, stride_, kMissing);
        continue;
      }
      const float* const in = depth_m.row(v);
      for (int u = 0; u < width_; u += V::kCount) {
        const V z = V::LoadUpTo(in + u, width_ - u);
        Select(z > 0., V(scale) / z, V(kMissing)).Store(out + margin_ + u);
      }
      std::fill_n(out, margin_, kMissing);
      std::fill(out + margin_ + width_, out + stride_, kMissing);
    }
  }

  // Pixel 0 of row v of the image; the row above or below is stride() before or after it.
  const float* row(int v) const { return values_.get() + (v - first_) * stride_ + margin_; }
  std::ptrdiff_t stride() const { return stride_; }

 private:
  static constexpr int kLanes = Lanes<float>::kCount;

  int width_;
  int margin_;
  std::ptrdiff_t stride_;
  int first_ = 0;  // row of the image that the uppermost row holds
  std::unique_ptr<float[]> values_;
};

}  // namespace surfit
