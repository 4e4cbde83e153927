#include "io/phones/resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

namespace surfit {
namespace {

// Coordinate of the own image: scale * coordinate of the common image + offset.
struct AxisMap {
  double scale = 1, offset = 0;

  double operator()(double at) const { return scale * at + offset; }
};

AxisMap ColumnMapOf(const PinholeCamera& own, const PinholeCamera& common) {
  const double scale = own.fx / common.fx;
  return {scale, own.cx - scale * common.cx};
}

AxisMap RowMapOf(const PinholeCamera& own, const PinholeCamera& common) {
  const double scale = own.fy / common.fy;
  return {scale, own.cy - scale * common.cy};
}

bool IsMeasured(std::uint16_t count) { return count != 0 && count != 65535; }
bool IsMeasured(float depth) { return std::isfinite(depth) && depth > 0; }

std::uint16_t Rounded(double depth, std::uint16_t /*type*/) {
  return static_cast<std::uint16_t>(std::lround(depth));
}
float Rounded(double depth, float /*type*/) { return static_cast<float>(depth); }

// Depth at (x, y): bilinear in inverse depth if the four pixels are on one surface.
template <typename T>
T DepthBetween(const Image<T>& depth, double x, double y) {
  constexpr double kSurface = 1.05;  // largest ratio of the depths of neighbours on one surface
  const int width = depth.width(), height = depth.height();
  const double nearest_x = std::floor(x + 0.5), nearest_y = std::floor(y + 0.5);
  if (!(nearest_x >= 0 && nearest_x < width && nearest_y >= 0 && nearest_y < height)) return 0;
  const T nearest = depth(static_cast<int>(nearest_x), static_cast<int>(nearest_y));
  if (!IsMeasured(nearest)) return 0;
  const int left = static_cast<int>(std::clamp(std::floor(x), 0., std::max(width - 2., 0.)));
  const int top = static_cast<int>(std::clamp(std::floor(y), 0., std::max(height - 2., 0.)));
  const int right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
  const std::array<T, 4> corners = {depth(left, top), depth(right, top), depth(left, bottom),
                                    depth(right, bottom)};
  if (!std::all_of(corners.begin(), corners.end(), [](T corner) { return IsMeasured(corner); }))
    return nearest;
  const auto [least, most] = std::minmax_element(corners.begin(), corners.end());
  if (static_cast<double>(*most) > kSurface * static_cast<double>(*least)) return nearest;
  const double a = x - left, b = y - top;
  const double inverse = (1 - b) * ((1 - a) / corners[0] + a / corners[1]) +
                         b * ((1 - a) / corners[2] + a / corners[3]);
  return inverse > 0 ? Rounded(1 / inverse, T()) : nearest;
}

// Position between two neighbouring pixels, with the weight of the second pixel in 1/256.
struct Between {
  int first = 0, second = 0, weight = 0;
};

std::vector<Between> PositionsOf(const AxisMap& map, int size) {
  std::vector<Between> positions(size);
  for (int i = 0; i < size; ++i) {
    const double at = std::clamp(map(i), 0., size - 1.);
    Between& position = positions[i];
    position.first = static_cast<int>(at);
    position.second = std::min(position.first + 1, size - 1);
    position.weight = static_cast<int>(std::lround(256 * (at - position.first)));
  }
  return positions;
}

std::uint8_t Blend(int a, int b, int c, int d, const Between& column, const Between& row) {
  const int top = (256 - column.weight) * a + column.weight * b;
  const int bottom = (256 - column.weight) * c + column.weight * d;
  return static_cast<std::uint8_t>(((256 - row.weight) * top + row.weight * bottom + (1 << 15)) >>
                                   16);
}

}  // namespace

double LargestShift(const PinholeCamera& a, const PinholeCamera& b) {
  const AxisMap columns = ColumnMapOf(a, b), rows = RowMapOf(a, b);
  const auto at = [](const AxisMap& map, int last) {
    return std::max(std::abs(map(0)), std::abs(map(last) - last));
  };
  return std::max(at(columns, b.width - 1), at(rows, b.height - 1));
}

void ResampleDepth(const PinholeCamera& own, const PinholeCamera& common, RawDepth* depth) {
  const AxisMap columns = ColumnMapOf(own, common), rows = RowMapOf(own, common);
  std::visit(
      [&](auto& image) {
        auto resampled = image;
        for (int v = 0; v < image.height(); ++v) {
          for (int u = 0; u < image.width(); ++u)
            resampled(u, v) = DepthBetween(image, columns(u), rows(v));
        }
        image = std::move(resampled);
      },
      *depth);
}

void ResampleColor(const PinholeCamera& own, const PinholeCamera& common, Image<Rgb8>* color) {
  const auto columns = PositionsOf(ColumnMapOf(own, common), color->width());
  const auto rows = PositionsOf(RowMapOf(own, common), color->height());
  Image<Rgb8> resampled(color->width(), color->height());
  for (int v = 0; v < color->height(); ++v) {
    const Between& row = rows[v];
    const Rgb8 *const top = color->row(row.first), *const bottom = color->row(row.second);
    Rgb8* const out = resampled.row(v);
    for (int u = 0; u < color->width(); ++u) {
      const Between& column = columns[u];
      const Rgb8 &a = top[column.first], &b = top[column.second];
      const Rgb8 &c = bottom[column.first], &d = bottom[column.second];
      out[u] = {Blend(a.r, b.r, c.r, d.r, column, row), Blend(a.g, b.g, c.g, d.g, column, row),
                Blend(a.b, b.b, c.b, d.b, column, row)};
    }
  }
  *color = std::move(resampled);
}

}  // namespace surfit
