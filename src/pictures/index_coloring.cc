#include "pictures/index_coloring.h"

#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {

Image<Rgb8> ColorIndices(const Image<std::int32_t>& indices,
                         const std::function<Rgb8(int, int, std::int32_t)>& color_of) {
  constexpr int kRowsPerBlock = 16;
  Image<Rgb8> colors(indices.width(), indices.height());
  ParallelFor(0, indices.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < indices.width(); ++u) colors(u, v) = color_of(u, v, indices(u, v));
    }
  });
  return colors;
}

Rgb8 Dimmed(Rgb8 color, float brightness) {
  const auto dim = [brightness](std::uint8_t component) {
    return static_cast<std::uint8_t>(std::lrint(component * brightness));
  };
  return {dim(color.r), dim(color.g), dim(color.b)};
}

}  // namespace surfit
