#include <glog/logging.h>

#include <limits>

#include "surfit/core/parallel.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

Image<float> Grey(const Image<Rgb8>& color) {
  Image<float> grey;
  grey.Resize(color.width(), color.height());
  ParallelFor(0, color.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < color.width(); ++u) {
        const Rgb8 c = color(u, v);
        grey(u, v) = c == Rgb8() ? std::numeric_limits<float>::quiet_NaN() : GreyOf(c);
      }
    }
  });
  return grey;
}

}  // namespace

Image<float> HalfResolution(const Image<float>& fine) {
  Image<float> coarse;
  coarse.Resize(fine.width() / 2, fine.height() / 2);
  ParallelFor(0, coarse.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const float *above = fine.row(2 * v), *below = fine.row(2 * v + 1);
      for (int u = 0; u < coarse.width(); ++u, above += 2, below += 2) {
        coarse(u, v) = (above[0] + above[1] + below[0] + below[1]) / 4;
      }
    }
  });
  return coarse;
}

void AddIntensity(const Image<Rgb8>& color, FramePyramid* pyramid) {
  if (color.empty()) return;
  const Image<float>* finer = nullptr;
  for (FrameLevel& level : pyramid->levels) {
    level.intensity = finer == nullptr ? Grey(color) : HalfResolution(*finer);
    CHECK_EQ(level.intensity.width(), level.camera.width);
    CHECK_EQ(level.intensity.height(), level.camera.height);
    finer = &level.intensity;
  }
}

}  // namespace surfit
