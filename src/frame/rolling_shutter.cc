#include "surfit/frame/rolling_shutter.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Motion moves pixels by a few pixels, and neighbours almost alike: each pass brings the pixel that
// moves to a place nearer by two orders of magnitude.
constexpr int kPasses = 2;

// Second differences of inverse depth beyond that many sigmas are edges: those of noise have 2.4.
constexpr float kMaxBendSigmas = 6;

struct PixelPlace {
  float u, v;
};

struct MovedPixel {
  float u, v, depth_m;
};

// Where the pixels of an image are in the middle of the readout.
class MovedPixels {
 public:
  MovedPixels(const Image<float>& depth_m, const DepthSensor& sensor, const CameraMotion& motion)
      : depth_m_(depth_m),
        fx_(static_cast<float>(sensor.camera.fx)),
        fy_(static_cast<float>(sensor.camera.fy)),
        cx_(static_cast<float>(sensor.camera.cx)),
        cy_(static_cast<float>(sensor.camera.cy)),
        seconds_per_row_(static_cast<float>(sensor.readout_s / depth_m.height())),
        turn_(motion.turn_rad_per_s.cast<float>()),
        velocity_(motion.velocity_m_per_s.cast<float>()) {}

  // X + tau (turn x X + velocity), divided by the depth z of X; the depth is 0 where that is
  // missing.
  MovedPixel operator()(int u, int v) const {
    const float z = depth_m_(u, v);
    const float tau = (static_cast<float>(v) + 0.5f) * seconds_per_row_ - middle_s();
    const float x = (static_cast<float>(u) - cx_) / fx_, y = (static_cast<float>(v) - cy_) / fy_;
    const float inverse = z > 0 ? 1 / z : 0;
    const float moved_x = x + tau * (turn_.y() - turn_.z() * y + velocity_.x() * inverse);
    const float moved_y = y + tau * (turn_.z() * x - turn_.x() + velocity_.y() * inverse);
    const float scale = 1 + tau * (turn_.x() * y - turn_.y() * x + velocity_.z() * inverse);
    return {fx_ * moved_x / scale + cx_, fy_ * moved_y / scale + cy_, z * scale};
  }

 private:
  float middle_s() const { return 0.5f * seconds_per_row_ * static_cast<float>(depth_m_.height()); }

  const Image<float>& depth_m_;
  float fx_, fy_, cx_, cy_, seconds_per_row_;
  Eigen::Vector3f turn_, velocity_;
};

// Where in the image, in parts of a pixel, what lies at (u, v) in the middle of the readout was
// seen.
PixelPlace OriginOf(const MovedPixels& moved, int width, int height, int u, int v) {
  PixelPlace at = {static_cast<float>(u), static_cast<float>(v)};
  for (int pass = 0; pass < kPasses; ++pass) {
    const int near_u = std::clamp(static_cast<int>(at.u + 0.5f), 0, width - 1);
    const int near_v = std::clamp(static_cast<int>(at.v + 0.5f), 0, height - 1);
    const MovedPixel there = moved(near_u, near_v);
    at.u = static_cast<float>(u) - (there.u - static_cast<float>(near_u));
    at.v = static_cast<float>(v) - (there.v - static_cast<float>(near_v));
  }
  return at;
}

// By how much inverse depth grows from one pixel to the next, by those on both sides; 0 where they
// do not continue a surface.
float SlopeBetween(float before_m, float here_m, float after_m, float max_bend) {
  if (!(before_m > 0 && after_m > 0)) return 0;
  const float before = 1 / before_m, here = 1 / here_m, after = 1 / after_m;
  return std::abs(before + after - 2 * here) <= max_bend ? (after - before) / 2 : 0;
}

// The share by which inverse depth differs from a pixel's at a place near it, on the same surface.
float GrowthNear(const Image<float>& depth_m, int u, int v, PixelPlace at, float max_bend) {
  if (u < 1 || v < 1 || u + 1 >= depth_m.width() || v + 1 >= depth_m.height()) return 0;
  const float here = depth_m(u, v);
  return here * ((at.u - static_cast<float>(u)) *
                     SlopeBetween(depth_m(u - 1, v), here, depth_m(u + 1, v), max_bend) +
                 (at.v - static_cast<float>(v)) *
                     SlopeBetween(depth_m(u, v - 1), here, depth_m(u, v + 1), max_bend));
}

}  // namespace

CameraMotion MotionOver(const Rigid3d& first_from_second, double seconds) {
  if (!(seconds > 0)) return {};
  const Eigen::Vector3d turn = QuaternionLog(first_from_second.rotation);
  // Halfway, as the second camera is by half the turn.
  const Eigen::Vector3d way = QuaternionExp<double>(-0.5 * turn) * first_from_second.translation;
  return {turn / seconds, way / seconds};
}

CameraMotion MotionAt(const Trajectory& trajectory, double stamp_s, double max_gap_s) {
  constexpr double kSameStamp = 1e-5;  // s; files have 6 decimals
  const auto at =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s - kSameStamp,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (at == trajectory.end() || at->stamp_s > stamp_s + kSameStamp) return {};
  auto first = at, last = at;
  if (at != trajectory.begin() && at->stamp_s - std::prev(at)->stamp_s <= max_gap_s) --first;
  if (std::next(at) != trajectory.end() && std::next(at)->stamp_s - at->stamp_s <= max_gap_s)
    ++last;
  return MotionOver(first->world_from_camera.Inverse() * last->world_from_camera,
                    last->stamp_s - first->stamp_s);
}

RgbdFrame AtMiddleOfReadout(const RgbdFrame& frame, const DepthSensor& sensor,
                            const CameraMotion& motion) {
  if (sensor.readout_s == 0 || motion.IsZero()) return frame;
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  const MovedPixels moved(frame.depth_m, sensor, motion);
  RgbdFrame result = {frame.index, frame.stamp_s, frame.color_stamp_s, {}, {}};
  result.depth_m.Resize(width, height);
  if (!frame.color.empty()) result.color.Resize(width, height);
  const auto max_bend = kMaxBendSigmas * static_cast<float>(sensor.noise.inverse_depth_sigma);
  const auto fill = [&](int u, int v) {
    const PixelPlace at = OriginOf(moved, width, height, u, v);
    const int from_u = static_cast<int>(std::floor(at.u + 0.5f));
    const int from_v = static_cast<int>(std::floor(at.v + 0.5f));
    const bool inside = from_u >= 0 && from_v >= 0 && from_u < width && from_v < height;
    if (!result.color.empty()) result.color(u, v) = inside ? frame.color(from_u, from_v) : Rgb8{};
    result.depth_m(u, v) = 0;
    if (!inside || frame.depth_m(from_u, from_v) == 0) return;
    const float growth = GrowthNear(frame.depth_m, from_u, from_v, at, max_bend);
    result.depth_m(u, v) = std::max(0.f, moved(from_u, from_v).depth_m / (1 + growth));
  };
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) fill(u, v);
    }
  });
  return result;
}

}  // namespace surfit
