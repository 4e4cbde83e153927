#include "mesh/texture/texture_painter.h"

#include <algorithm>
#include <array>

#include "mesh/texture/triangle_pixels.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {
namespace {

Eigen::Vector3f ToVector(Rgb8 color) { return Eigen::Vector3f(color.r, color.g, color.b); }

Eigen::Vector3f ColorAt(const Image<Rgb8>& image, const Eigen::Vector2f& at) {
  const float u = std::clamp(at.x(), 0.f, static_cast<float>(image.width() - 1));
  const float v = std::clamp(at.y(), 0.f, static_cast<float>(image.height() - 1));
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const int right = std::min(left + 1, image.width() - 1);
  const int bottom = std::min(top + 1, image.height() - 1);
  const float s = u - static_cast<float>(left), t = v - static_cast<float>(top);
  return (1 - t) * ((1 - s) * ToVector(image(left, top)) + s * ToVector(image(right, top))) +
         t * ((1 - s) * ToVector(image(left, bottom)) + s * ToVector(image(right, bottom)));
}

// Extends the painted area by one texel. A new texel gets the mean colour of its painted
// neighbours.
void Widen(int width, int height, std::vector<Eigen::Vector3f>* colors,
           std::vector<std::uint8_t>* is_painted) {
  const std::vector<std::uint8_t> before = *is_painted;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * width + x;
      if (before[at] != 0) continue;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      for (int w = std::max(0, y - 1); w <= std::min(height - 1, y + 1); ++w) {
        for (int z = std::max(0, x - 1); z <= std::min(width - 1, x + 1); ++z) {
          const std::size_t other = static_cast<std::size_t>(w) * width + z;
          if (before[other] == 0) continue;
          sum += (*colors)[other];
          ++count;
        }
      }
      if (count == 0) continue;
      (*colors)[at] = sum / static_cast<float>(count);
      (*is_painted)[at] = 1;
    }
  }
}

}  // namespace

TexturePainter::TexturePainter(const TriangleMesh& mesh, const TextureLayout& layout,
                               const PackedSize& size)
    : mesh_(mesh),
      layout_(layout),
      share_(static_cast<float>(size.pixel_ratio)),
      image_(size.width, size.height) {}

void TexturePainter::Paint(const TextureChart& chart, const Image<Rgb8>& frame,
                           const Eigen::Vector3f& gain) {
  Colors differences;
  for (std::uint32_t i = chart.first_place; i < chart.end_place; ++i) {
    const Eigen::Vector3f shown = gain.cwiseProduct(ColorAt(frame, layout_.pixels[i]));
    differences.push_back(ToVector(mesh_.colors[layout_.vertices[i]]) - shown);
  }
  Smooth(chart, &differences);
  std::vector<std::uint8_t> is_painted;
  const Colors added = Spread(chart, differences, &is_painted);
  for (int y = 0; y < chart.height; ++y) {
    for (int x = 0; x < chart.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * chart.width + x;
      if (is_painted[at] == 0) continue;
      const Eigen::Vector2f texel(x - kChartMargin_px, y - kChartMargin_px);
      const Eigen::Vector3f shown = gain.cwiseProduct(ColorAt(frame, chart.low + texel / share_));
      image_(chart.left + x, chart.top + y) = ToRgb8(shown + added[at]);
    }
  }
}

void TexturePainter::PaintColors(const TextureChart& chart) {
  Colors colors;
  for (std::uint32_t i = chart.first_place; i < chart.end_place; ++i)
    colors.push_back(ToVector(mesh_.colors[layout_.vertices[i]]));
  std::vector<std::uint8_t> is_painted;
  const Colors painted = Spread(chart, colors, &is_painted);
  for (int y = 0; y < chart.height; ++y) {
    for (int x = 0; x < chart.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * chart.width + x;
      if (is_painted[at] != 0) image_(chart.left + x, chart.top + y) = ToRgb8(painted[at]);
    }
  }
}

Eigen::Vector2f TexturePainter::CoordinatesOf(const TextureChart& chart,
                                              const Eigen::Vector2f& pixel) const {
  const Eigen::Vector2f texel = InChart(chart, pixel) + Eigen::Vector2f(chart.left, chart.top);
  return {(texel.x() + 0.5f) / static_cast<float>(image_.width()),
          (texel.y() + 0.5f) / static_cast<float>(image_.height())};
}

// Smooths one colour per vertex: repeatedly replaces each colour by its mean over adjacent
// triangles.
void TexturePainter::Smooth(const TextureChart& chart, Colors* of_places) const {
  constexpr int kRounds = 40;  // smoothing radius: about six triangle sides
  Colors sums(of_places->size());
  std::vector<float> weights(of_places->size());
  for (int round = 0; round < kRounds; ++round) {
    std::fill(sums.begin(), sums.end(), Eigen::Vector3f::Zero());
    std::fill(weights.begin(), weights.end(), 0.f);
    for (const std::uint32_t i : chart.triangles) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const std::uint32_t place : layout_.triangles[i])
        sum += (*of_places)[place - chart.first_place];
      for (const std::uint32_t place : layout_.triangles[i]) {
        sums[place - chart.first_place] += sum;
        weights[place - chart.first_place] += 3;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) (*of_places)[i] = sums[i] / weights[i];
  }
}

TexturePainter::Colors TexturePainter::Spread(const TextureChart& chart, const Colors& of_places,
                                              std::vector<std::uint8_t>* is_painted) const {
  const std::size_t count = static_cast<std::size_t>(chart.width) * chart.height;
  Colors colors(count);
  is_painted->assign(count, 0);
  const auto paint = [&](int x, int y, const Eigen::Vector3f& color) {
    const std::size_t at = static_cast<std::size_t>(y) * chart.width + x;
    colors[at] = color;
    (*is_painted)[at] = 1;
  };
  for (const std::uint32_t i : chart.triangles) {
    Eigen::Matrix3f of_corners;
    std::array<Eigen::Vector2f, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t place = layout_.triangles[i][k];
      corners[k] = InChart(chart, layout_.pixels[place]);
      of_corners.col(k) = of_places[place - chart.first_place];
      paint(static_cast<int>(corners[k].x() + 0.5f), static_cast<int>(corners[k].y() + 0.5f),
            of_corners.col(k));
    }
    VisitPixels(
        corners[0], corners[1], corners[2], chart.width, chart.height,
        [&](int x, int y, const Eigen::Vector3f& shares) { paint(x, y, of_corners * shares); });
  }
  for (int i = 0; i < kChartMargin_px; ++i) Widen(chart.width, chart.height, &colors, is_painted);
  return colors;
}

}  // namespace surfit
