#include "output/pictures/map_views.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Sample {
  std::vector<Eigen::Vector3f> points, normals;
  std::vector<float> areas;
};

Sample DrawSample(const SurfelMap& map, const std::vector<std::uint8_t>& shown) {
  constexpr std::size_t kSize = 50000;
  const std::vector<std::int32_t> ids = map.Ids();
  const std::size_t stride = std::max<std::size_t>(1, ids.size() / kSize);
  Sample sample;
  for (std::size_t i = 0; i < ids.size(); i += stride) {
    if (!shown[ids[i]]) continue;
    const Surfel surfel = map[ids[i]];
    sample.points.push_back(surfel.position_in_world);
    sample.normals.push_back(surfel.normal_in_world);
    sample.areas.push_back(surfel.radius_m * surfel.radius_m);
  }
  return sample;
}

// Refines the up direction to the mean normal of horizontal surfaces.
Eigen::Vector3d RefineUp(const Sample& sample, Eigen::Vector3d up) {
  constexpr double kLeastRatio = 0.02;
  const double total = std::accumulate(sample.areas.begin(), sample.areas.end(), 0.);
  for (const double gate_rad : {0.75, 0.5, 0.35, 0.25}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < sample.normals.size(); ++i) {
      const Eigen::Vector3d n = sample.normals[i].cast<double>();
      if (n.dot(up) > std::cos(gate_rad)) sum += sample.areas[i] * n;
    }
    if (!(sum.norm() > kLeastRatio * total)) break;
    up = sum.normalized();
  }
  return up;
}

// right-handed, in the world frame
struct RoomAxes {
  Eigen::Vector3d across, along, up;
};

// Wall normals are horizontal and at right angles.
RoomAxes FindRoomAxes(const Sample& sample, const Eigen::Vector3d& up) {
  const Eigen::Vector3d x = up.unitOrthogonal(), y = up.cross(x);
  double sum_cos = 0, sum_sin = 0;
  for (std::size_t i = 0; i < sample.points.size(); ++i) {
    const Eigen::Vector3d n = sample.normals[i].cast<double>();
    const double horizontal = 1 - std::pow(n.dot(up), 2);
    const double weight = sample.areas[i] * std::pow(horizontal, 4);
    const double azimuth = std::atan2(n.dot(y), n.dot(x));
    sum_cos += weight * std::cos(4 * azimuth);
    sum_sin += weight * std::sin(4 * azimuth);
  }
  const double wall = std::atan2(sum_sin, sum_cos) / 4;
  const Eigen::Vector3d across = std::cos(wall) * x + std::sin(wall) * y;
  return {across, up.cross(across), up};
}

RoomAxes ChooseRoomAxes(const Sample& sample, const Trajectory& path,
                        const std::optional<UprightWorld>& upright) {
  if (!upright) return FindRoomAxes(sample, RefineUp(sample, UpDirection(path)));
  const Eigen::Matrix3d axes = upright->upright_from_world.rotation.toRotationMatrix().transpose();
  if (!upright->walls_give_axes) return FindRoomAxes(sample, axes.col(2));
  return {axes.col(0), axes.col(1), axes.col(2)};
}

struct Bounds {
  Eigen::Vector3d center;
  double diagonal_m;
};

Bounds FindBounds(const Sample& sample) {
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (const Eigen::Vector3f& p : sample.points) values.push_back(p[axis]);
    low[axis] = Quantile(values, 0.01, 0);
    high[axis] = Quantile(values, 0.99, 1);
  }
  return {(low + high) / 2, std::max(1e-3, (high - low).norm())};
}

// View along `forward` from outside the scene, fitted to the front faces.
PictureView OutsideView(const std::string& label, const Sample& sample, const Bounds& bounds,
                        const Eigen::Vector3d& forward, const Eigen::Vector3d& up,
                        double distance_in_diagonals, int width, int height) {
  PictureView view;
  view.label = label;
  const Eigen::Vector3d eye =
      bounds.center - distance_in_diagonals * bounds.diagonal_m * forward.normalized();
  view.camera_from_world = LookAlong(eye, forward, up);
  std::vector<Eigen::Vector3f> seen;
  for (std::size_t i = 0; i < sample.points.size(); ++i) {
    const Eigen::Vector3d point = sample.points[i].cast<double>();
    if (sample.normals[i].cast<double>().dot(point - eye) >= 0) continue;
    seen.emplace_back((view.camera_from_world * point).cast<float>());
  }
  view.camera = FitCamera(seen, width, height);
  return view;
}

// View from above, from so far away that walls are almost lines. The vertical axis of the picture
// is the room axis with the larger scale. It points in the viewing direction of the first camera.
PictureView TopView(const Sample& sample, const Bounds& bounds, const RoomAxes& axes,
                    const Eigen::Vector3d& first_forward, int width, int height) {
  constexpr double kDistance = 4;
  PictureView best;
  for (Eigen::Vector3d page_up : {axes.along, axes.across}) {
    if (page_up.dot(first_forward) < 0) page_up = -page_up;
    PictureView view =
        OutsideView("from above", sample, bounds, -axes.up, page_up, kDistance, width, height);
    if (view.camera.fx > best.camera.fx) best = std::move(view);
  }
  return best;
}

// Oblique view from above, at the azimuth with the largest area of front faces.
PictureView BirdView(const Sample& sample, const Bounds& bounds, const RoomAxes& axes, int width,
                     int height) {
  constexpr double kDistance = 1.5, kElevation = 0.65;
  constexpr int kAzimuths = 16;
  Eigen::Vector3d best_forward = -axes.up;
  double best_area = -1;
  for (int k = 0; k < kAzimuths; ++k) {
    const double azimuth = 2 * kPi * k / kAzimuths;
    const Eigen::Vector3d towards_eye =
        std::cos(kElevation) * (std::cos(azimuth) * axes.across + std::sin(azimuth) * axes.along) +
        std::sin(kElevation) * axes.up;
    double area = 0;
    for (std::size_t i = 0; i < sample.points.size(); ++i) {
      const double cosine = sample.normals[i].cast<double>().dot(towards_eye);
      area += sample.areas[i] * std::max(0., cosine);
    }
    if (area > best_area) best_area = area, best_forward = -towards_eye;
  }
  return OutsideView("bird's eye", sample, bounds, best_forward, axes.up, kDistance, width, height);
}

// Median depth of the points in a 90 degree cone in front of the camera; 1 m without points.
double MedianDepth(const Sample& sample, const Rigid3d& camera_from_world) {
  std::vector<float> depths;
  for (const Eigen::Vector3f& point : sample.points) {
    const Eigen::Vector3d p = camera_from_world * point.cast<double>();
    if (p.z() > p.head<2>().norm()) depths.push_back(p.z());
  }
  return Quantile(std::move(depths), 0.5, 1);
}

// View from a pose of the path, moved back along the optical axis.
PictureView PulledBackView(const std::string& label, const Sample& sample, const Rigid3d& pose,
                           int width, int height) {
  constexpr double kPulledBack = 0.2;
  constexpr double kFocal =
      0.75;  // focal length relative to the width: field of view of 67 degrees
  PictureView view;
  view.label = label;
  view.camera_from_world = pose.Inverse();
  view.camera_from_world.translation.z() +=
      kPulledBack * MedianDepth(sample, view.camera_from_world);
  view.camera.width = width;
  view.camera.height = height;
  view.camera.fx = view.camera.fy = kFocal * width;
  view.camera.cx = (width - 1) / 2.;
  view.camera.cy = (height - 1) / 2.;
  return view;
}

}  // namespace

std::size_t MostDifferentPose(const Trajectory& camera_path, double scene_depth_m) {
  std::size_t most = 0;
  double most_difference = 0;
  for (std::size_t i = 1; i < camera_path.size(); ++i) {
    const Rigid3d first_from_this =
        camera_path.front().world_from_camera.Inverse() * camera_path[i].world_from_camera;
    const double difference = RotationAngle(first_from_this.rotation) +
                              first_from_this.translation.norm() / scene_depth_m;
    if (difference > most_difference) most_difference = difference, most = i;
  }
  return most;
}

std::array<PictureView, 4> ChooseMapViews(const SurfelMap& map,
                                          const std::vector<std::uint8_t>& shown,
                                          const Trajectory& camera_path,
                                          const std::optional<UprightWorld>& upright, int width,
                                          int height) {
  const Trajectory path = camera_path.empty() ? Trajectory(1) : camera_path;
  const Rigid3d first = path.front().world_from_camera;
  const Sample sample = DrawSample(map, shown);
  const Bounds bounds = FindBounds(sample);
  const RoomAxes axes = ChooseRoomAxes(sample, path, upright);
  const std::size_t other = MostDifferentPose(path, MedianDepth(sample, first.Inverse()));
  const Eigen::Vector3d first_forward = first.rotation * Eigen::Vector3d::UnitZ();
  return {TopView(sample, bounds, axes, first_forward, width, height),
          BirdView(sample, bounds, axes, width, height),
          PulledBackView("first camera, pulled back", sample, first, width, height),
          PulledBackView(Concat("camera ", other + 1, " of ", path.size(), ", pulled back"), sample,
                         path[other].world_from_camera, width, height)};
}

}  // namespace surfit
