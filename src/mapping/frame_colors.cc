#include "mapping/frame_colors.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr float kBlur_s = 0.005f;
constexpr float kPixelsPerMetre = 500.f;

bool IsBlack(Rgb8 color) { return color == Rgb8(); }

}  // namespace

FrameColors::FrameColors(const RgbdFrame& frame, const PosedCamera& camera,
                         const FrameMotion& motion)
    : color_(frame.color),
      fx_(camera.fx),
      fy_(camera.fy),
      cx_(camera.cx),
      cy_(camera.cy),
      turn_(motion.camera.turn_rad_per_s.cast<float>()),
      velocity_(motion.camera.velocity_m_per_s.cast<float>()),
      middle_s_(static_cast<float>(frame.color_stamp_s - frame.stamp_s)),
      row_s_(static_cast<float>(motion.readout_s / camera.height)) {
  if (!color_.empty()) FindBorders();
}

void FrameColors::FindBorders() {
  const int width = color_.width(), height = color_.height();
  const auto range_of = [](int size, const auto& is_black) {
    Range range = {0, size};
    while (range.begin < size && is_black(range.begin)) ++range.begin;
    while (range.end > range.begin && is_black(range.end - 1)) --range.end;
    return range;
  };
  for (int v = 0; v < height; ++v) {
    rows_.push_back(range_of(width, [&](int u) { return IsBlack(color_(u, v)); }));
  }
  for (int u = 0; u < width; ++u) {
    columns_.push_back(range_of(height, [&](int v) { return IsBlack(color_(u, v)); }));
  }
}

SeenColor FrameColors::At(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f way = turn_.cross(point) + velocity_;
  const float rho = 1.f / point.z(), x = point.x() * rho, y = point.y() * rho;
  const float u = fx_ * x + cx_, v = fy_ * y + cy_;
  const float u_per_s = -fx_ * rho * (way.x() - x * way.z());
  const float v_per_s = -fy_ * rho * (way.y() - y * way.z());
  // The row that shows it is read at t = t0 + (v + v_per_s t) row_s.
  const float t0 = middle_s_ + (v + 0.5f - 0.5f * static_cast<float>(color_.height())) * row_s_;
  const float t = t0 / std::max(0.5f, 1.f - v_per_s * row_s_);
  SeenColor seen = Sample(u + u_per_s * t, v + v_per_s * t);
  const float fineness = fx_ * rho / kPixelsPerMetre;
  const float cosine = std::fabs(normal.dot(point)) / point.norm();
  const float blur2 = (u_per_s * u_per_s + v_per_s * v_per_s) * (kBlur_s * kBlur_s);
  seen.weight *= fineness * fineness * cosine / ((1.f + blur2) * (1.f + blur2));
  return seen;
}

// Pixels beside the border's count for nothing; black ones count only where all four are, as where
// there is no depth there may be no colour.
SeenColor FrameColors::Sample(float u, float v) const {
  const int width = color_.width(), height = color_.height();
  if (!(u > -0.5f && v > -0.5f && u < static_cast<float>(width) - 0.5f &&
        v < static_cast<float>(height) - 0.5f)) {
    return {};
  }
  const float at_u = std::clamp(u, 0.f, static_cast<float>(width - 1));
  const float at_v = std::clamp(v, 0.f, static_cast<float>(height - 1));
  const int left = std::min(static_cast<int>(at_u), width - 2);
  const int top = std::min(static_cast<int>(at_v), height - 2);
  const float right_share = at_u - static_cast<float>(left);
  const float lower_share = at_v - static_cast<float>(top);
  SeenColor seen;
  bool is_inside = true;
  for (int k = 0; k < 4; ++k) {
    const int pixel_u = left + k % 2, pixel_v = top + k / 2;
    is_inside &= IsInside(pixel_u, pixel_v);
    const Rgb8 pixel = color_(pixel_u, pixel_v);
    if (IsBlack(pixel)) continue;
    const float share = (k % 2 == 1 ? right_share : 1.f - right_share) *
                        (k / 2 == 1 ? lower_share : 1.f - lower_share);
    seen.color += share * Eigen::Vector3f(pixel.r, pixel.g, pixel.b);
    seen.weight += share;
  }
  if (!is_inside) return {};
  if (seen.weight > 0.f) seen.color /= seen.weight;
  seen.weight = 1.f;
  return seen;
}

}  // namespace surfit
