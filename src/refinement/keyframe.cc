#include "surfit/refinement/keyframe.h"

#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "surfit/frame/intensity.h"

namespace surfit {
namespace {

constexpr double kSmoothingPx = 2;

// Nearer pixels differ by noise and by how they fall on the texture.
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

}  // namespace

KeyframeImages MakeKeyframeImages(const RgbdFrame& frame, const PinholeCamera& camera,
                                  const PreprocessOptions& options) {
  PreprocessOptions finest = options;
  finest.pyramid_levels = 1;
  FramePyramid pyramid = PreprocessDepth(frame.depth_m, camera, finest);
  AddIntensity(frame.color, &pyramid);
  FrameLevel& level = pyramid.levels.front();
  const int width = camera.width, height = camera.height;
  KeyframeImages images;
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

}  // namespace surfit
