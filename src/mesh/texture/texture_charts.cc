#include "mesh/texture/texture_charts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::uint32_t kNoPlace = std::numeric_limits<std::uint32_t>::max();

std::vector<std::uint32_t> ConnectedTo(std::uint32_t first, const TriangleNeighbors& neighbors,
                                       const std::vector<int>& views, std::vector<bool>* is_done) {
  std::vector<std::uint32_t> found = {first};
  (*is_done)[first] = true;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const std::uint32_t other : neighbors.Of(found[i])) {
      if (other == TriangleNeighbors::kNone || (*is_done)[other] || views[other] != views[first])
        continue;
      (*is_done)[other] = true;
      found.push_back(other);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Places the charts in rows ("shelves") from top to bottom. Sets chart positions, chart sizes and
// the used height. Returns false if the charts do not fit.
bool PlaceOnShelves(double share, int width, int max_height, const std::vector<std::size_t>& order,
                    std::vector<TextureChart>* charts, int* height) {
  int left = 0, top = 0, shelf = 0;
  for (const std::size_t i : order) {
    TextureChart& chart = (*charts)[i];
    const auto size = [&](float pixels) {
      return static_cast<int>(std::ceil(share * pixels)) + 1 + 2 * kChartMargin_px;
    };
    chart.width = size(chart.high.x() - chart.low.x());
    chart.height = size(chart.high.y() - chart.low.y());
    if (chart.width > width) return false;
    if (left + chart.width > width) {
      left = 0;
      top += shelf;
      shelf = 0;
    }
    chart.left = left;
    chart.top = top;
    left += chart.width;
    shelf = std::max(shelf, chart.height);
    if (top + shelf > max_height) return false;
  }
  *height = top + shelf;
  return true;
}

}  // namespace

// Sets the pixel size to half the mean triangle side.
ColorViews::ColorViews(const TriangleMesh& mesh) {
  double sum = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles)
    sum += (mesh.vertices[t[1]] - mesh.vertices[t[0]]).norm();
  pixel_m_ = static_cast<float>(std::max(
      1e-6, sum / static_cast<double>(2 * std::max<std::size_t>(1, mesh.triangles.size()))));
}

int ColorViews::ViewOf(const TriangleMesh& mesh, const TriangleMesh::Triangle& triangle) const {
  const Eigen::Vector3f& a = mesh.vertices[triangle[0]];
  const Eigen::Vector3f normal =
      (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a);
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (normal[axis] < 0 ? 1 : 0);
}

Eigen::Vector2f ColorViews::See(int view, const Eigen::Vector3f& point) const {
  const int axis = view / 2;
  return Eigen::Vector2f(point[(axis + 1) % 3], point[(axis + 2) % 3]) / pixel_m_;
}

TextureLayout MakeCharts(const TriangleMesh& mesh, const TriangleNeighbors& neighbors,
                         const std::vector<int>& views, const std::vector<TextureCamera>& cameras,
                         const ColorViews& color_views) {
  TextureLayout layout;
  layout.triangles.resize(mesh.triangles.size());
  std::vector<bool> is_done(mesh.triangles.size());
  std::vector<std::uint32_t> place_of(mesh.vertices.size(), kNoPlace);
  const auto see = [&](int view, const Eigen::Vector3f& point) {
    const int frames = static_cast<int>(cameras.size());
    if (view >= frames) return color_views.See(view - frames, point);
    const TextureCamera::Place place = cameras[view].See(point);
    return Eigen::Vector2f(place.u, place.v);
  };
  for (std::uint32_t first = 0; first < mesh.triangles.size(); ++first) {
    if (is_done[first]) continue;
    TextureChart chart;
    chart.view = views[first];
    chart.triangles = ConnectedTo(first, neighbors, views, &is_done);
    chart.first_place = static_cast<std::uint32_t>(layout.pixels.size());
    chart.low.setConstant(std::numeric_limits<float>::infinity());
    chart.high = -chart.low;
    for (const std::uint32_t i : chart.triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t vertex = mesh.triangles[i][k];
        std::uint32_t& place = place_of[vertex];
        if (place == kNoPlace || place < chart.first_place) {
          place = static_cast<std::uint32_t>(layout.pixels.size());
          layout.vertices.push_back(vertex);
          layout.pixels.push_back(see(chart.view, mesh.vertices[vertex]));
          chart.low = chart.low.cwiseMin(layout.pixels.back());
          chart.high = chart.high.cwiseMax(layout.pixels.back());
        }
        layout.triangles[i][k] = place;
      }
    }
    chart.end_place = static_cast<std::uint32_t>(layout.pixels.size());
    layout.charts.push_back(std::move(chart));
  }
  return layout;
}

PackedSize PackCharts(int max_side_px, std::vector<TextureChart>* charts) {
  std::vector<std::size_t> order(charts->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto height = [&](std::size_t i) { return (*charts)[i].high.y() - (*charts)[i].low.y(); };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return height(a) > height(b); });
  constexpr double kSmaller = 0.95, kSmallest = 0.02;
  PackedSize size;
  for (; size.pixel_ratio > kSmallest; size.pixel_ratio *= kSmaller) {
    double area = 0, widest = 0;
    for (const TextureChart& chart : *charts) {
      const Eigen::Vector2d sides = size.pixel_ratio * (chart.high - chart.low).cast<double>() +
                                    Eigen::Vector2d::Constant(2 + 2 * kChartMargin_px);
      area += sides.prod();
      widest = std::max(widest, sides.x());
    }
    const double side = std::max(widest, 1.05 * std::sqrt(area));
    if (side > 2. * max_side_px) continue;
    size.width = std::min(max_side_px, static_cast<int>(std::ceil(side)));
    if (PlaceOnShelves(size.pixel_ratio, size.width, max_side_px, order, charts, &size.height))
      return size;
  }
  throw InputError("max_texture_px is ", max_side_px, ", which is too small for the mesh's ",
                   charts->size(), " charts: increase it or cell_m");
}

}  // namespace surfit
