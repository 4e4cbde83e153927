#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/core/error.h"
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

Image<float> GradientCells(const Image<Rgb8>& color, int cell) {
  Image<float> change(color.width(), color.height(), 0.F);
  double sum = 0;
  for (int v = 1; v + 1 < color.height(); ++v) {
    for (int u = 1; u + 1 < color.width(); ++u) {
      change(u, v) = std::abs(GreyOf(color(u + 1, v)) - GreyOf(color(u - 1, v))) +
                     std::abs(GreyOf(color(u, v + 1)) - GreyOf(color(u, v - 1)));
      sum += change(u, v);
    }
  }
  const auto most = static_cast<float>(4 * sum / static_cast<double>(change.size()) + 1e-9);
  Image<float> cells(color.width() / cell, color.height() / cell, 0.F);
  for (int v = 0; v < cells.height() * cell; ++v) {
    for (int u = 0; u < cells.width() * cell; ++u)
      cells(u / cell, v / cell) += std::min(change(u, v), most);
  }
  double mean = 0, variance = 0;
  for (const float c : cells) mean += c / static_cast<double>(cells.size());
  for (const float c : cells) variance += (c - mean) * (c - mean);
  const double sigma = std::sqrt(variance / static_cast<double>(cells.size())) + 1e-9;
  for (float& c : cells) c = static_cast<float>((c - mean) / sigma);
  return cells;
}

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
    ThrowIf(level.intensity.width() != level.camera.width ||
                level.intensity.height() != level.camera.height,
            "the colour image has ", color.width(), " x ", color.height(), " pixels, must have ",
            pyramid->levels.front().camera.width, " x ", pyramid->levels.front().camera.height,
            " like depth");
    finer = &level.intensity;
  }
}

}  // namespace surfit
