#include "apps/export/moving_masks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "apps/export/color_lens.h"

namespace surfit {
namespace {

constexpr float kDistance_m = 0.1f, kDistanceRatio = 0.02f;
constexpr double kMinPart = 0.005;  // pixels of a part / pixels
constexpr double kMargin = 0.01;    // of the mask / image width

cv::Mat ViewOf(Image<std::uint8_t>* image) {
  return {image->height(), image->width(), CV_8U, image->data()};
}

cv::Mat Disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

}  // namespace

Image<std::uint8_t> PixelsInFront(const Image<float>& depth_m, const Image<float>& map_depth_m) {
  Image<std::uint8_t> in_front(depth_m.width(), depth_m.height(), 0);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const float z = depth_m[i], map = map_depth_m[i];
    if (z > 0 && map > 0 && map - z > kDistance_m + kDistanceRatio * z) in_front[i] = 255;
  }
  cv::Mat mask = ViewOf(&in_front);
  // Borders of surfaces and noise are thin.
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, Disc(std::max(1, depth_m.width() / 160)));
  cv::Mat parts, statistics, centers;
  const int count = cv::connectedComponentsWithStats(mask, parts, statistics, centers);
  const double min_pixels = kMinPart * static_cast<double>(depth_m.size());
  for (int part = 1; part < count; ++part) {
    if (statistics.at<int>(part, cv::CC_STAT_AREA) < min_pixels) mask.setTo(0, parts == part);
  }
  return in_front;
}

Image<std::uint8_t> MaskOfColor(const Image<std::uint8_t>& in_front, const Image<float>& depth_m,
                                const PinholeCamera& depth_camera, const Rigid3d& color_from_depth,
                                const PinholeCamera& lens) {
  Image<std::uint8_t> moving(lens.width, lens.height, 0);
  cv::Mat mask = ViewOf(&moving);
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (in_front(u, v) == 0) continue;
      const double z = depth_m(u, v);
      const Eigen::Vector3d point = color_from_depth * (z * depth_camera.Ray(u, v));
      const std::optional<LensPoint> seen = ProjectByLens(lens, point);
      if (!seen || !IsInside(lens, seen->pixel, 0)) continue;
      // A depth pixel covers this many colour pixels.
      const double size = z / depth_camera.fx * lens.fx / point.z();
      const int half = static_cast<int>(std::ceil(0.5 * size));
      const cv::Point at(static_cast<int>(std::lround(seen->pixel.x())),
                         static_cast<int>(std::lround(seen->pixel.y())));
      cv::rectangle(mask, at - cv::Point(half, half), at + cv::Point(half, half), 255, cv::FILLED);
    }
  }
  const cv::Mat margin = Disc(std::max(1, static_cast<int>(std::lround(kMargin * lens.width))));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, margin);
  cv::dilate(mask, mask, margin);
  cv::bitwise_not(mask, mask);
  return moving;
}

Image<std::uint8_t> UndistortMask(const Image<std::uint8_t>& mask, const PinholeCamera& distorted,
                                  const PinholeCamera& lens) {
  Image<Rgb8> gray(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.size(); ++i) gray[i] = {mask[i], mask[i], mask[i]};
  const Image<Rgb8> undistorted = Undistort(gray, distorted, lens);
  Image<std::uint8_t> result(undistorted.width(), undistorted.height(), 255);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (undistorted[i].g < 255) result[i] = 0;
  }
  return result;
}

}  // namespace surfit
