#include "output/pictures/picture_view.h"

#include <algorithm>
#include <cmath>

namespace surfit {

Eigen::Vector3d UpDirection(const Trajectory& camera_path) {
  const auto up_of = [](const StampedPose& pose) -> Eigen::Vector3d {
    return pose.world_from_camera.rotation * -Eigen::Vector3d::UnitY();
  };
  if (camera_path.empty()) return -Eigen::Vector3d::UnitY();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : camera_path) sum += up_of(pose);
  constexpr double kVanishes = 1e-3;
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
  constexpr double kTail = 0.005;  // maximum ratio of points outside, per side
  constexpr double kFilled = 0.94;
  constexpr float kMinExtent = 1e-3f;
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
  camera.fx = kFilled * std::min(width / std::max(right - left, kMinExtent),
                                 height / std::max(bottom - top, kMinExtent));
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

}  // namespace surfit
