#include "pictures/picture_view.h"

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

Eigen::Vector3d UpDirection(const Trajectory& camera_path) {
  const auto up_of = [](const StampedPose& pose) -> Eigen::Vector3d {
    return pose.world_from_camera.rotation * -Eigen::Vector3d::UnitY();
  };
  if (camera_path.empty()) return -Eigen::Vector3d::UnitY();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : camera_path) sum += up_of(pose);
  constexpr double kVanishes = 1e-3;  // of the sum of as many parallel axes
  if (sum.norm() < kVanishes * camera_path.size()) return up_of(camera_path.front());
  return sum.normalized();
}

Rigid3d LookAlong(const Eigen::Vector3d& eye, const Eigen::Vector3d& forward,
                  const Eigen::Vector3d& up) {
  Eigen::Matrix3d world_from_camera;
  world_from_camera.col(2) = forward.normalized();
  world_from_camera.col(0) = forward.cross(up).normalized();
  world_from_camera.col(1) = world_from_camera.col(2).cross(world_from_camera.col(0));
  return Rigid3d(world_from_camera, eye).Inverse();
}

PinholeCamera FitCamera(const std::vector<Eigen::Vector3f>& points_in_camera, int width,
                        int height) {
  constexpr double kTail = 0.005;  // share of the points on each side that may fall outside
  constexpr double kFilled = 0.94;
  constexpr float kLeastExtent = 1e-3f;  // of z = 1
  std::vector<float> x, y;
  for (const Eigen::Vector3f& p : points_in_camera) {
    if (p.z() <= 0) continue;
    x.push_back(p.x() / p.z());
    y.push_back(p.y() / p.z());
  }
  const float left = Quantile(x, kTail, -0.5f), right = Quantile(x, 1 - kTail, 0.5f);
  const float top = Quantile(y, kTail, -0.5f), bottom = Quantile(y, 1 - kTail, 0.5f);
  PinholeCamera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = kFilled * std::min(width / std::max(right - left, kLeastExtent),
                                 height / std::max(bottom - top, kLeastExtent));
  camera.fy = camera.fx;
  camera.cx = (width - 1) / 2. - camera.fx * (left + right) / 2;
  camera.cy = (height - 1) / 2. - camera.fy * (top + bottom) / 2;
  return camera;
}

float Quantile(std::vector<float> values, double q, float otherwise) {
  if (values.empty()) return otherwise;
  const auto nth = values.begin() + std::lround(q * (values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

LiveMapView Overview(const std::vector<Eigen::Vector3f>& points_in_world,
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
  LiveMapView overview = {{}, center, up};
  PictureView& view = overview.view;
  view.camera_from_world = LookAlong(eye, forward, up);
  view.camera =
      FitCamera(CornersOfAll(points_in_world, camera_path, view.camera_from_world), width, height);
  return overview;
}

LiveMapView Turned(LiveMapView overview, const MapOrbit& orbit, const Trajectory& camera_path) {
  constexpr double kFromTop_rad = 0.05;  // that the eye keeps from straight above and below
  constexpr double kFollowing = 0.4;     // of the distance
  const auto kStraightDown = static_cast<double>(EIGEN_PI);
  const bool follows = orbit.follows && !camera_path.empty();
  Rigid3d& camera_from_world = overview.view.camera_from_world;
  const Eigen::Vector3d up = overview.up.normalized();
  Eigen::Vector3d offset = camera_from_world.Inverse().translation - overview.target;
  const double angle = std::acos(std::clamp(offset.normalized().dot(up), -1., 1.));
  const double turned =
      std::clamp(angle - orbit.up_rad, kFromTop_rad, kStraightDown - kFromTop_rad) - angle;
  offset = Eigen::AngleAxisd(turned, up.cross(offset).normalized()) * offset;
  offset = Eigen::AngleAxisd(orbit.right_rad, up) * offset;
  offset *= orbit.distance * (follows ? kFollowing : 1);
  overview.target = orbit.shift_m +
                    (follows ? camera_path.back().world_from_camera.translation : overview.target);
  camera_from_world = LookAlong(overview.target + offset, -offset, up);
  if (follows) {
    PinholeCamera& camera = overview.view.camera;
    camera.cx = (camera.width - 1) / 2.;
    camera.cy = (camera.height - 1) / 2.;
  }
  return overview;
}

}  // namespace surfit
