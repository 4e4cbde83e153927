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
  // Of each row or column and the one after it; is_black(i, j) of pixel i of line j.
  const auto ranges_of = [](int lines, int size, const auto& is_black) {
    std::vector<Range> ranges;
    for (int j = 0; j < lines; ++j) {
      Range own = {0, size};
      while (own.begin < size && is_black(own.begin, j)) ++own.begin;
      while (own.end > own.begin && is_black(own.end - 1, j)) --own.end;
      --own.end;  // of the first of two pixels
      if (j > 0) {
        ranges[j - 1] = {std::max(ranges[j - 1].begin, own.begin),
                         std::min(ranges[j - 1].end, own.end)};
      }
      ranges.push_back(own);
    }
    return ranges;
  };
  const int width = color_.width(), height = color_.height();
  rows_ = ranges_of(height, width, [&](int u, int v) { return IsBlack(color_(u, v)); });
  columns_ = ranges_of(width, height, [&](int v, int u) { return IsBlack(color_(u, v)); });
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
  if (!rows_[top].Has(left) || !columns_[left].Has(top)) return {};
  const Rgb8* const upper = color_.row(top) + left;
  const Rgb8* const lower = color_.row(top + 1) + left;
  const float left_share = 1.f - right_share, upper_share = 1.f - lower_share;
  SeenColor seen;
  const auto add = [&](Rgb8 pixel, float share) {
    if (IsBlack(pixel)) return;
    seen.color += share * Eigen::Vector3f(pixel.r, pixel.g, pixel.b);
    seen.weight += share;
  };
  add(upper[0], left_share * upper_share);
  add(upper[1], right_share * upper_share);
  add(lower[0], left_share * lower_share);
  add(lower[1], right_share * lower_share);
  if (seen.weight > 0.f) seen.color /= seen.weight;
  seen.weight = 1.f;
  return seen;
}

}  // namespace surfit
