#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "surfit/core/image.h"
#include "surfit/core/lanes.h"

namespace surfit {

// Calls f(value). The usual value is passed as a constant, so that loops over it are unrolled.
template <int kUsual, typename F>
void WithConstant(int value, const F& f) {
  if (value == kUsual) {
    f(std::integral_constant<int, kUsual>());
  } else {
    f(value);
  }
}

// Scaled inverse depth (scale / z) of some rows of a depth image, with a margin for filter windows
// and SIMD lanes. Missing pixels and pixels outside of the image are kMissing. The difference of a
// valid and a missing pixel exceeds every threshold, so windows need no branch.
class InverseDepthBand {
 public:
  static constexpr float kMissing = -1e30f;

  // Buffer for images of `width` columns and for up to `rows` rows, plus `margin` pixels on each
  // side. Call Fill() before row().
  InverseDepthBand(int width, int rows, int margin)
      : width_(width),
        margin_(margin),
        stride_((width + kLanes - 1) / kLanes * kLanes + 2 * margin),
        values_(new float[static_cast<std::size_t>(rows + 2 * margin) * stride_]) {}

  // Loads the rows [begin, end) of a depth image (m; missing unless positive) and the rows of the
  // margin. The image has the width of the band, and end - begin is at most `rows`. Both are not
  // checked.
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

  // Pointer to pixel 0 of image row v, from begin - margin to end + margin - 1 of Fill(). stride()
  // is the distance of rows in values. Pixels from -margin to width + margin - 1 are readable, with
  // `width` rounded up to a multiple of Lanes<float>::kCount.
  const float* row(int v) const { return values_.get() + (v - first_) * stride_ + margin_; }
  std::ptrdiff_t stride() const { return stride_; }

 private:
  static constexpr int kLanes = Lanes<float>::kCount;

  int width_;
  int margin_;
  std::ptrdiff_t stride_;
  int first_ = 0;
  std::unique_ptr<float[]> values_;
};

}  // namespace surfit
