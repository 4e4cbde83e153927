#include "surfit/optimization/keyframes.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "frame/rolling_shutter.h"
#include "surfit/core/error.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr double kSmoothingPx = 2;

// Suppresses noise and aliasing.
Image<float> Smoothed(Image<float> intensity) {
  if (intensity.empty()) return intensity;
  cv::Mat image(intensity.height(), intensity.width(), CV_32F, intensity.data());
  cv::GaussianBlur(image, image, cv::Size(), kSmoothingPx);
  return intensity;
}

void SetPixel(float measured_m, const FrameLevel& level, int u, int v, KeyframeImages* images) {
  if (!(measured_m > 0)) return;
  images->inverse_depth(u, v) = 1 / measured_m;
  const Eigen::Vector3d normal = level.normal(u, v).cast<double>();
  const double distance = normal.dot(level.vertex(u, v).cast<double>());
  if (!(distance < 0)) return;  // no normal
  images->slope_u(u, v) = static_cast<float>(normal.x() / (level.camera.fx * distance));
  images->slope_v(u, v) = static_cast<float>(normal.y() / (level.camera.fy * distance));
}

std::vector<std::size_t> MovedPoses(const Trajectory& trajectory, double min_translation_m,
                                    double min_rotation_rad) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (chosen.empty() ||
        HasMoved(trajectory[chosen.back()].world_from_camera, trajectory[i].world_from_camera,
                 min_translation_m, min_rotation_rad)) {
      chosen.push_back(i);
    }
  }
  return chosen;
}

}  // namespace

KeyframeImages MakeKeyframeImages(const RgbdFrame& measured, const DepthSensor& sensor,
                                  const CameraMotion& motion, const PreprocessOptions& options) {
  const RgbdFrame frame = CorrectRollingShutter(measured, sensor, motion);
  PreprocessOptions finest = options;
  finest.pyramid_levels = 1;
  FramePyramid pyramid = PreprocessDepth(frame.depth_m, sensor, finest);
  AddIntensity(frame.color, &pyramid);
  FrameLevel& level = pyramid.levels.front();
  const int width = sensor.camera.width, height = sensor.camera.height;
  KeyframeImages images;
  images.noise = sensor.noise;
  images.readout = {motion, sensor.readout_s};
  images.inverse_depth = Image<float>(width, height, 0.f);
  images.slope_u = images.slope_v =
      Image<float>(width, height, std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) SetPixel(frame.depth_m(u, v), level, u, v, &images);
  }
  images.intensity = Smoothed(std::move(level.intensity));
  return images;
}

bool HasMoved(const Rigid3d& a, const Rigid3d& b, double min_translation_m,
              double min_rotation_rad) {
  return (a.translation - b.translation).norm() > min_translation_m ||
         RotationAngle(Eigen::Quaterniond(a.rotation.conjugate() * b.rotation)) > min_rotation_rad;
}

std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count) {
  constexpr double kGrowth = 1.1;
  constexpr double kSmallest = 1e-4;  // m or rad; a threshold of 0 would not grow
  std::vector<std::size_t> chosen = MovedPoses(trajectory, min_translation_m, min_rotation_rad);
  while (max_count > 0 && chosen.size() > std::max<std::size_t>(max_count, 1)) {
    min_translation_m = std::max(kGrowth * min_translation_m, kSmallest);
    min_rotation_rad = std::max(kGrowth * min_rotation_rad, kSmallest);
    chosen = MovedPoses(trajectory, min_translation_m, min_rotation_rad);
  }
  return chosen;
}

Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe) {
  ThrowIf(keyframes.empty() || keyframes.size() != world_from_keyframe.size(), "there are ",
          keyframes.size(), " keyframes and ", world_from_keyframe.size(),
          " refined poses, must be equal and at least 1");
  const auto moved = [&](std::size_t k, const Rigid3d& pose) {
    const Rigid3d& before = trajectory[keyframes[k]].world_from_camera;
    return world_from_keyframe[k] * (before.Inverse() * pose);
  };
  Trajectory corrected = trajectory;
  std::size_t k = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    while (k + 1 < keyframes.size() && keyframes[k + 1] <= i) ++k;
    const Rigid3d& pose = trajectory[i].world_from_camera;
    Rigid3d& result = corrected[i].world_from_camera;
    result = moved(k, pose);
    if (k + 1 == keyframes.size() || i <= keyframes[k]) continue;
    const double begin = trajectory[keyframes[k]].stamp_s;
    const double end = trajectory[keyframes[k + 1]].stamp_s;
    const double share = (trajectory[i].stamp_s - begin) / (end - begin);
    const Rigid3d next = moved(k + 1, pose);
    result.rotation = result.rotation.slerp(share, next.rotation).normalized();
    result.translation += share * (next.translation - result.translation);
  }
  return corrected;
}

}  // namespace surfit
