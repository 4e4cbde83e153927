#include "io/checks/color_faults.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr std::size_t kFewestImages = 3;
// Correlation of neighbouring pixels. It is above 0.8 for images and near 0 for noise.
constexpr double kNoise = 0.3;
constexpr int kSampledPixel =
    3;  // every kSampledPixel-th pixel of a row is compared with its neighbour

double NeighborCorrelation(const Image<Rgb8>& color) {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int v = 0; v < color.height(); v += kSampledPixel) {
    for (int u = 0; u + 1 < color.width(); u += kSampledPixel) {
      const double x = color(u, v).g, y = color(u + 1, v).g;
      ++count;
      a += x;
      b += y;
      aa += x * x;
      bb += y * y;
      ab += x * y;
    }
  }
  const double variances = (aa * count - a * a) * (bb * count - b * b);
  return variances > 0 ? (ab * count - a * b) / std::sqrt(variances) : 1;
}

}  // namespace

std::optional<std::string> ColorFault(const std::vector<FrameImages>& images) {
  std::vector<const FrameImages*> colored;
  for (const FrameImages& image : images)
    if (!image.color.empty()) colored.push_back(&image);
  if (colored.size() < kFewestImages) return std::nullopt;
  const auto all_of_rest = [&](const auto& test) {
    return std::all_of(colored.begin() + 1, colored.end(),
                       [&](const FrameImages* image) { return test(*image); });
  };
  const FrameImages& first = *colored.front();
  if (all_of_rest([&](const FrameImages& i) { return i.color == first.color; }) &&
      all_of_rest([&](const FrameImages& i) { return !(i.depth == first.depth); }))
    return first.color_name + " repeats while depth changes";
  const auto is_noise = [](const FrameImages& i) { return NeighborCorrelation(i.color) < kNoise; };
  if (is_noise(first) && all_of_rest(is_noise))
    return "colour is noise: neighbouring pixels are not similar";
  return std::nullopt;
}

}  // namespace surfit
