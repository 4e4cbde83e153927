#include "apps/export/map_visibility.h"

#include <algorithm>
#include <cmath>

#include "finishing/color_registration.h"
#include "output/pictures/pictures.h"

namespace surfit {
namespace {

// Camera of the rendered depth: without distortion, and with a margin for the corners that the
// distortion moves out of the image.
PinholeCamera DepthCamera(const PinholeCamera& lens, int columns) {
  PinholeCamera camera = lens.Binned(std::max(1, lens.width / columns));
  camera.distortion = {};
  const double margin_ratio = lens.HasDistortion() ? 0.1 : 0.02;
  const int margin_u = static_cast<int>(margin_ratio * camera.width);
  const int margin_v = static_cast<int>(margin_ratio * camera.height);
  camera.width += 2 * margin_u;
  camera.height += 2 * margin_v;
  camera.cx += margin_u;
  camera.cy += margin_v;
  return camera;
}

}  // namespace

MapDepth::MapDepth(const SurfelMap& map, const PinholeCamera& lens, int columns)
    : map_(map), renderer_(RenderOptions()) {
  sensor_.camera = DepthCamera(lens, columns);
}

void MapDepth::Render(const Rigid3d& world_from_color) {
  depth_m_ = DrawnDiscs(renderer_.Render(map_, sensor_, world_from_color), map_).depth_m;
}

bool MapDepth::IsVisible(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  constexpr double kMinDepth_m = 0.05, kMinCosine = 0.17;  // 80 degrees
  constexpr double kThickness_m = 0.02, kThicknessRatio = 0.01;
  if (!(point.z() > kMinDepth_m)) return false;
  if (!(-normal.dot(point) > kMinCosine * point.norm())) return false;
  const Eigen::Vector2d pixel = sensor_.camera.Project(point);
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  if (u < 1 || v < 1 || u > sensor_.camera.width - 2 || v > sensor_.camera.height - 2) return false;
  // The surface may be slanted within a pixel.
  const double cosine = -normal.dot(point) / point.norm();
  const double slope_m = point.z() / sensor_.camera.fx * std::sqrt(1 - cosine * cosine) / cosine;
  const double tolerance_m = kThickness_m + kThicknessRatio * point.z() + 1.5 * slope_m;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const float depth_m = depth_m_(u + du, v + dv);
      if (!(depth_m > 0 && std::abs(depth_m - point.z()) < tolerance_m)) return false;
    }
  }
  return true;
}

}  // namespace surfit
