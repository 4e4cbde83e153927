#include "apps/export/sparse_points.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "apps/export/color_lens.h"
#include "apps/export/map_visibility.h"
#include "output/pictures/pictures.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxPoints = 60000;
constexpr int kVisibilityColumns = 320;
constexpr double kFirstEdge_m = 0.005, kEdgeGrowth = 1.2;

std::vector<Surfel> OnePerCube(const std::vector<Surfel>& surfels, double edge_m) {
  std::map<std::array<std::int64_t, 3>, std::size_t> best;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    std::array<std::int64_t, 3> cube;
    for (int k = 0; k < 3; ++k) {
      cube[k] = static_cast<std::int64_t>(std::floor(surfels[i].position_in_world[k] / edge_m));
    }
    const auto [entry, is_new] = best.emplace(cube, i);
    if (!is_new && surfels[i].confidence > surfels[entry->second].confidence) entry->second = i;
  }
  std::vector<Surfel> result;
  for (const auto& [cube, i] : best) result.push_back(surfels[i]);
  return result;
}

}  // namespace

std::vector<Surfel> ThinOut(const std::vector<Surfel>& surfels, std::size_t most) {
  std::vector<Surfel> thinned = surfels;
  for (double edge_m = kFirstEdge_m; thinned.size() > most; edge_m *= kEdgeGrowth) {
    thinned = OnePerCube(thinned, edge_m);
  }
  return thinned;
}

SparsePoints FindSparsePoints(const SurfelMap& map, const PinholeCamera& lens,
                              const std::vector<PosedImage>& images) {
  const std::vector<Surfel> candidates = ThinOut(ReliableSurfels(map), kMaxPoints);
  MapDepth depth(map, lens, kVisibilityColumns);
  std::vector<std::vector<PointView>> views(images.size());
  std::vector<int> counts(candidates.size(), 0);
  for (std::size_t i = 0; i < images.size(); ++i) {
    depth.Render(images[i].world_from_color);
    const Rigid3d color_from_world = images[i].world_from_color.Inverse();
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const Eigen::Vector3d point =
          color_from_world * candidates[k].position_in_world.cast<double>();
      const std::optional<LensPoint> seen = ProjectByLens(lens, point);
      if (!seen || !IsInside(lens, seen->pixel, 0)) continue;
      const Eigen::Vector3d normal =
          color_from_world.rotation * candidates[k].normal_in_world.cast<double>();
      if (!depth.IsVisible(point, normal)) continue;
      views[i].push_back({static_cast<std::int32_t>(k), seen->pixel});
      ++counts[k];
    }
  }
  SparsePoints result;
  std::vector<std::int32_t> number(candidates.size(), -1);
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (counts[k] < 2) {
      ++result.unseen;
      continue;
    }
    number[k] = static_cast<std::int32_t>(result.points.size());
    result.points.push_back(candidates[k]);
  }
  result.views.resize(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const PointView& view : views[i]) {
      if (number[view.point] >= 0) result.views[i].push_back({number[view.point], view.pixel});
    }
  }
  return result;
}

}  // namespace surfit
