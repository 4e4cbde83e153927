#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/doctor/recording_statistics.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr int kWindow = 15;             // averaging window, px; maximum of the measured width
constexpr int kUsualWidth_px = 640;     // larger images are downsampled to about this width
constexpr float kContrast = 0.1F;       // minimum range of intensities in [0, 1] around an edge
constexpr double kFewestEdges = 0.002;  // minimum ratio of edge pixels

Image<float> SmallGrey(const Image<Rgb8>& color, int factor) {
  Image<float> grey(color.width() / factor, color.height() / factor, 0.F);
  const float share = 1.F / static_cast<float>(factor * factor);
  for (int v = 0; v < grey.height() * factor; ++v) {
    for (int u = 0; u < grey.width() * factor; ++u)
      grey(u / factor, v / factor) += share * GreyOf(color(u, v));
  }
  return grey;
}

struct EdgeSums {
  // Sum of absolute intensity differences of adjacent pixels at edges. `lost`: reduction of this
  // sum if lines are averaged over kWindow pixels.
  double differences = 0, lost = 0;
  std::size_t edges = 0;
};

void AddLine(const std::vector<float>& line, EdgeSums* sums) {
  constexpr int kHalf = kWindow / 2;
  const int size = static_cast<int>(line.size());
  if (size <= kWindow + 1) return;
  for (int i = kHalf; i + kHalf + 1 < size; ++i) {
    const auto [least, most] =
        std::minmax_element(line.begin() + i - kHalf, line.begin() + i + kHalf + 1);
    if (*most - *least < kContrast) continue;
    const double difference = std::abs(line[i + 1] - line[i]);
    const double averaged = std::abs(line[i + kHalf + 1] - line[i - kHalf]) / kWindow;
    sums->differences += difference;
    sums->lost += std::max(0., difference - averaged);
    ++sums->edges;
  }
}

std::optional<double> WidthOf(const EdgeSums& sums, std::size_t pixels) {
  if (static_cast<double>(sums.edges) < kFewestEdges * static_cast<double>(pixels)) return {};
  if (!(sums.differences > 0)) return {};
  return kWindow * (1 - sums.lost / sums.differences);
}

}  // namespace

std::optional<double> EdgeWidth(const Image<Rgb8>& color) {
  const int factor = std::max(1, color.width() / kUsualWidth_px);
  const Image<float> grey = SmallGrey(color, factor);
  EdgeSums along_rows, along_columns;
  std::vector<float> line(grey.width());
  for (int v = 0; v < grey.height(); ++v) {
    std::copy(grey.row(v), grey.row(v) + grey.width(), line.begin());
    AddLine(line, &along_rows);
  }
  line.resize(grey.height());
  for (int u = 0; u < grey.width(); ++u) {
    for (int v = 0; v < grey.height(); ++v) line[v] = grey(u, v);
    AddLine(line, &along_columns);
  }
  const auto rows = WidthOf(along_rows, grey.size()), columns = WidthOf(along_columns, grey.size());
  if (!rows && !columns) return {};
  return std::max(rows.value_or(0), columns.value_or(0)) / grey.width();
}

}  // namespace surfit
