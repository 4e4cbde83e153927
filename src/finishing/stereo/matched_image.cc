#include "finishing/stereo/matched_image.h"

#include <algorithm>

namespace surfit {
namespace {

constexpr int kCensusU = 4, kCensusV = 3;                 // half sizes of the window, px
constexpr int kImageNoise = 4;                            // of brightness
constexpr std::uint64_t kValid = std::uint64_t{1} << 63;  // a window has 63 pixels
constexpr int kMeanRadius = 3;                            // px

std::uint64_t CensusAt(const Image<std::uint8_t>& brightness, int u, int v) {
  const std::uint8_t centre = brightness(u, v);
  std::uint64_t bits = 0;
  for (int y = v - kCensusV; y <= v + kCensusV; ++y) {
    const std::uint8_t* const row = brightness.row(y) + u;
    for (int x = -kCensusU; x <= kCensusU; ++x)
      bits = bits << 1 | (row[x] + kImageNoise < centre ? 1 : 0);
  }
  return bits;
}

// Images can have some black pixels. Only areas of them are not visible.
bool IsVisible(const Image<Rgb8>& color, int u, int v) {
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if (color(x, y) != Rgb8()) return true;
    }
  }
  return false;
}

std::uint8_t DetailAt(const Image<std::uint8_t>& brightness, int u, int v) {
  int sum = 0, count = 0;
  for (int y = std::max(0, v - kMeanRadius);
       y <= std::min(brightness.height() - 1, v + kMeanRadius); ++y) {
    for (int x = std::max(0, u - kMeanRadius);
         x <= std::min(brightness.width() - 1, u + kMeanRadius); ++x) {
      sum += brightness(x, y);
      ++count;
    }
  }
  return static_cast<std::uint8_t>(std::clamp(128 + brightness(u, v) - sum / count, 0, 255));
}

}  // namespace

MatchedImage::MatchedImage(const StereoKeyframe& keyframe)
    : camera(keyframe.camera),
      world_from_camera(keyframe.world_from_camera),
      brightness(Brightness(keyframe.color)),
      detail(camera.width, camera.height),
      census(camera.width, camera.height, 0) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) detail(u, v) = DetailAt(brightness, u, v);
  }
  for (int v = kCensusV; v < camera.height - kCensusV; ++v) {
    for (int u = kCensusU; u < camera.width - kCensusU; ++u) {
      if (IsVisible(keyframe.color, u, v)) census(u, v) = CensusAt(brightness, u, v) | kValid;
    }
  }
}

EpipolarLines LinesBetween(const MatchedImage& from, const MatchedImage& to) {
  const Rigid3d pose = to.world_from_camera.Inverse() * from.world_from_camera;
  const PinholeCamera& camera = to.camera;
  Eigen::Matrix3d to_pixels;
  to_pixels << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return {(to_pixels * pose.rotation.toRotationMatrix()).cast<float>(),
          (to_pixels * pose.translation).cast<float>()};
}

}  // namespace surfit
