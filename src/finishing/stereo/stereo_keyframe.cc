#include "finishing/stereo/stereo_keyframe.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr int kMinColumns = 320;

// Mean of the visible pixels of a square; (0, 0, 0) without them.
Rgb8 MeanOf(const Image<Rgb8>& color, int left, int top, int size) {
  int r = 0, g = 0, b = 0, n = 0;
  const int right = left + size, bottom = top + size;
  if (left < 0 || top < 0 || right > color.width() || bottom > color.height()) return {};
  for (int v = top; v < bottom; ++v) {
    for (int u = left; u < right; ++u) {
      const Rgb8 pixel = color(u, v);
      if (pixel == Rgb8()) continue;
      r += pixel.r, g += pixel.g, b += pixel.b;
      ++n;
    }
  }
  if (n == 0) return {};
  const auto mean = [&](int sum) { return static_cast<std::uint8_t>((sum + n / 2) / n); };
  return {mean(r), mean(g), mean(b)};
}

// Bins the image. A row that is read `t` after the middle shows the ray X at X - t (turn x X). The
// square of a bin is moved by this displacement.
Image<Rgb8> BinWithoutRotation(const Image<Rgb8>& color, const DepthSensor& sensor,
                               const CameraMotion& motion, int factor) {
  const PinholeCamera& camera = sensor.camera;
  const PinholeCamera binned = camera.Binned(factor);
  Image<Rgb8> bins(binned.width, binned.height);
  const double middle = 0.5 * (camera.height - 1), half = 0.5 * (factor - 1);
  for (int v = 0; v < binned.height; ++v) {
    for (int u = 0; u < binned.width; ++u) {
      const double at_u = factor * u + half, at_v = factor * v + half;
      const double t = (at_v - middle) / camera.height * sensor.readout_s;
      const Eigen::Vector3d ray = camera.Ray(at_u, at_v);
      const Eigen::Vector2d seen =
          camera.Project(ray - t * motion.angular_velocity_rad_per_s.cross(ray));
      bins(u, v) = MeanOf(color, static_cast<int>(std::lround(seen.x() - half)),
                          static_cast<int>(std::lround(seen.y() - half)), factor);
    }
  }
  return bins;
}

// Nearest depth of the points that project into each pixel.
Image<float> Projected(const Image<float>& depth_m, const PinholeCamera& from,
                       const Rigid3d& to_from, const PinholeCamera& to) {
  Image<float> found(to.width, to.height, 0.f);
  const Eigen::Matrix3d rotation = to_from.rotation.toRotationMatrix();
  for (int v = 0; v < from.height; ++v) {
    for (int u = 0; u < from.width; ++u) {
      const double z = depth_m(u, v);
      if (!(z > 0)) continue;
      const Eigen::Vector3d point = rotation * (z * from.Ray(u, v)) + to_from.translation;
      if (!(point.z() > 0)) continue;
      const Eigen::Vector2d pixel = to.Project(point).array() + 0.5;
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < to.width && pixel.y() < to.height)) {
        continue;
      }
      float& nearest = found(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
      const auto depth = static_cast<float>(point.z());
      if (!(nearest > 0) || depth < nearest) nearest = depth;
    }
  }
  return found;
}

}  // namespace

StereoKeyframe MakeStereoKeyframe(const RgbdFrame& frame, const Image<float>& depth_m,
                                  const DepthSensor& sensor, const CameraMotion& motion,
                                  const Rigid3d& world_from_camera,
                                  const Rigid3d& world_from_color) {
  const int factor = std::max(1, sensor.camera.width / kMinColumns);
  const PinholeCamera camera = sensor.camera.Binned(factor);
  return {
      frame.index, camera, world_from_color,
      BinWithoutRotation(frame.color, sensor, motion, factor),
      Projected(depth_m, sensor.camera, world_from_color.Inverse() * world_from_camera, camera)};
}

Image<std::uint8_t> Brightness(const Image<Rgb8>& color) {
  Image<std::uint8_t> found(color.width(), color.height());
  std::transform(color.begin(), color.end(), found.begin(),
                 [](Rgb8 c) { return static_cast<std::uint8_t>(255 * GreyOf(c) + 0.5f); });
  return found;
}

}  // namespace surfit
