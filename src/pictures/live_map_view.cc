#include "pictures/live_map_view.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

// Where things lie along one axis.
struct Extent {
  double low, high;
};

// Of all poses, and of the points without the farthest 1 % on each side.
Extent ExtentOf(const std::vector<Eigen::Vector3f>& points, const Trajectory& path, int axis) {
  constexpr double kTail = 0.01;
  std::vector<float> values;
  values.reserve(points.size());
  for (const Eigen::Vector3f& p : points) values.push_back(p[axis]);
  Extent extent = {Quantile(values, kTail, 0), Quantile(values, 1 - kTail, 1)};
  for (const StampedPose& pose : path) {
    extent.low = std::min(extent.low, pose.world_from_camera.translation[axis]);
    extent.high = std::max(extent.high, pose.world_from_camera.translation[axis]);
  }
  return extent;
}

// Forward along the ground as the first camera looked, and down by the elevation.
Eigen::Vector3d ViewDirection(const Trajectory& path, const Eigen::Vector3d& up) {
  constexpr double kElevation = 0.65;  // rad
  constexpr double kVanishes = 0.05;   // a camera that looks straight down has no such direction
  const Eigen::Vector3d forward =
      path.empty() ? Eigen::Vector3d(0, 0, 1)
                   : path.front().world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  Eigen::Vector3d level = forward - forward.dot(up) * up;
  if (level.norm() < kVanishes) level = up.unitOrthogonal();
  return std::cos(kElevation) * level.normalized() - std::sin(kElevation) * up;
}

// Two corners, at z = 1 of the camera, of a box that holds the points but for a few far off, and
// every pose of the path.
std::vector<Eigen::Vector3f> CornersOfAll(const std::vector<Eigen::Vector3f>& points_in_world,
                                          const Trajectory& path,
                                          const Rigid3d& camera_from_world) {
  constexpr double kTail = 0.005;
  std::vector<float> x, y;
  for (const Eigen::Vector3f& point : points_in_world) {
    const Eigen::Vector3d p = camera_from_world * point.cast<double>();
    x.push_back(static_cast<float>(p.x() / p.z()));
    y.push_back(static_cast<float>(p.y() / p.z()));
  }
  Eigen::Vector3f low(Quantile(x, kTail, 0), Quantile(y, kTail, 0), 1);
  Eigen::Vector3f high(Quantile(x, 1 - kTail, 0), Quantile(y, 1 - kTail, 0), 1);
  for (const StampedPose& pose : path) {
    const Eigen::Vector3d p = camera_from_world * pose.world_from_camera.translation;
    if (p.z() <= 0) continue;
    low = low.cwiseMin((p / p.z()).cast<float>());
    high = high.cwiseMax((p / p.z()).cast<float>());
  }
  return {low, high};
}

}  // namespace

PictureView LiveMapView(const std::vector<Eigen::Vector3f>& points_in_world,
                        const Trajectory& camera_path, int width, int height) {
  constexpr double kDistance = 1.5;  // in diagonals of map and path
  Eigen::Vector3d center, size;
  for (int axis = 0; axis < 3; ++axis) {
    const Extent extent = ExtentOf(points_in_world, camera_path, axis);
    center[axis] = (extent.low + extent.high) / 2;
    size[axis] = extent.high - extent.low;
  }
  const Eigen::Vector3d up = UpDirection(camera_path);
  const Eigen::Vector3d forward = ViewDirection(camera_path, up);
  const Eigen::Vector3d eye = center - kDistance * std::max(1e-3, size.norm()) * forward;
  PictureView view;
  view.camera_from_world = LookAlong(eye, forward, up);
  view.camera =
      FitCamera(CornersOfAll(points_in_world, camera_path, view.camera_from_world), width, height);
  return view;
}

}  // namespace surfit
