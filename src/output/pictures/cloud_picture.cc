#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "output/pictures/canvas.h"
#include "output/pictures/map_views.h"
#include "output/pictures/pictures.h"
#include "output/pictures/splat_renderer.h"

namespace surfit {
namespace {

constexpr Rgb8 kSourceColor = {240, 120, 0};
constexpr Rgb8 kTargetColor = {20, 90, 210};
constexpr int kPointSize_px = 3;
constexpr int kViewWidth = PictureSheet::kCellWidth * PictureSheet::kSupersampling;
constexpr int kViewHeight = PictureSheet::kCellHeight * PictureSheet::kSupersampling;

PictureView FittedView(const std::string& label, const std::vector<Eigen::Vector3f>& points,
                       const Rigid3d& camera_from_world) {
  PictureView view;
  view.label = label;
  view.camera_from_world = camera_from_world;
  std::vector<Eigen::Vector3f> in_camera;
  in_camera.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    in_camera.emplace_back((camera_from_world * p.cast<double>()).cast<float>());
  }
  view.camera = FitCamera(in_camera, kViewWidth, kViewHeight);
  return view;
}

// View at the median point from the upper right, 1.3 times as far away as the camera.
Rigid3d ObliqueView(const std::vector<Eigen::Vector3f>& points) {
  constexpr double kToTheRight = 0.6, kAbove = 0.45, kDistance = 1.3;
  Eigen::Vector3d center;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    values.reserve(points.size());
    for (const Eigen::Vector3f& p : points) values.push_back(p[axis]);
    center[axis] = Quantile(std::move(values), 0.5, axis == 2 ? 1 : 0);
  }
  const Eigen::Vector3d towards_eye = Eigen::Vector3d(kToTheRight, -kAbove, -1).normalized();
  const double distance = kDistance * std::max(0.1, center.norm());
  return LookAlong(center + distance * towards_eye, -towards_eye, -Eigen::Vector3d::UnitY());
}

// Eye-dome lighting (Boucheny 2009): darkens pixels behind their neighbours, without normals.
// `log_depth`: logarithm of the depth; infinite without a point.
float EyeDomeLight(const Image<float>& log_depth, int u, int v) {
  constexpr int kReach_px = 2;
  constexpr float kStrength = 12, kDarkest = 0.35f;
  float behind = 0;
  for (const auto& [du, dv] :
       {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
    const int nu = u + kReach_px * du, nv = v + kReach_px * dv;
    if (nu < 0 || nv < 0 || nu >= log_depth.width() || nv >= log_depth.height()) continue;
    behind += std::max(0.f, log_depth(u, v) - log_depth(nu, nv));
  }
  return std::max(kDarkest, std::exp(-kStrength * behind));
}

Image<Rgb8> ColorPoints(const std::vector<Eigen::Vector3f>& points, std::size_t source_count,
                        const PictureView& view) {
  const Image<std::int32_t> indices = RenderPoints(points, kPointSize_px, view);
  const Rigid3f camera_from_world = view.camera_from_world.cast<float>();
  Image<float> log_depth(indices.width(), indices.height(), std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] == NearestIndexImage::kNothing) continue;
    log_depth[i] = std::log((camera_from_world * points[indices[i]]).z());
  }
  return ColorIndices(indices, [&](int u, int v, std::int32_t i) {
    if (i == NearestIndexImage::kNothing) return PictureSheet::kScene;
    const bool is_source = static_cast<std::size_t>(i) < source_count;
    return Dimmed(is_source ? kSourceColor : kTargetColor, EyeDomeLight(log_depth, u, v));
  });
}

// True if 99 % of the points have positive depth for a camera at the origin.
bool AreBeforeTheOrigin(const std::vector<Eigen::Vector3f>& points) {
  const auto before =
      std::count_if(points.begin(), points.end(), [](const auto& p) { return p.z() > 0; });
  return static_cast<double>(before) >= 0.99 * static_cast<double>(points.size());
}

// Translation along z that puts all points in front of a camera at the origin.
Eigen::Vector3f ShiftBeforeTheOrigin(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  return Eigen::Vector3f(0, 0, box.diagonal().norm()) - box.center();
}

void DrawEntry(Image<Rgb8>* image, double u, Rgb8 color, const std::string& name) {
  constexpr double kMiddle = PictureSheet::kHeaderHeight / 2.;
  FillBox(image, {u, kMiddle - 9, u + 40, kMiddle + 9}, color);
  DrawText(image, {u + 54, kMiddle}, name, {20, 0, PictureSheet::kInk});
}

}  // namespace

void WriteTwoCloudPicture(const std::vector<Eigen::Vector3f>& source,
                          const std::vector<Eigen::Vector3f>& target, const std::string& path) {
  std::vector<Eigen::Vector3f> points = source;
  points.insert(points.end(), target.begin(), target.end());
  const bool is_view = AreBeforeTheOrigin(target);
  if (!is_view) {
    const Eigen::Vector3f shift = ShiftBeforeTheOrigin(target);
    for (Eigen::Vector3f& p : points) p += shift;
  }
  const std::array<PictureView, 2> views = {
      FittedView(is_view ? "from the target camera" : "along the z axis", points, Rigid3d()),
      FittedView("from the right and above", points, ObliqueView(points))};
  PictureSheet sheet(2, 1);
  for (int i = 0; i < 2; ++i) {
    sheet.SetCell(i, ColorPoints(points, source.size(), views[i]));
    sheet.DrawCaption(i, views[i].label);
  }
  DrawEntry(sheet.image(), 20, kSourceColor, "source");
  DrawEntry(sheet.image(), 220, kTargetColor, "target");
  WritePng(*sheet.image(), path);
}

}  // namespace surfit
