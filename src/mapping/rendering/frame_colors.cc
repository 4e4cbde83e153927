#include "mapping/rendering/frame_colors.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "surfit/core/lanes.h"

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
      turn_(motion.camera.angular_velocity_rad_per_s.cast<float>()),
      velocity_(motion.camera.velocity_m_per_s.cast<float>()),
      middle_s_(static_cast<float>(frame.color_stamp_s - frame.stamp_s)),
      row_s_(static_cast<float>(motion.readout_s / camera.height)) {
  if (!color_.empty()) FindBorders();
}

void FrameColors::FindBorders() {
  // Range j has the pixels i that can be interpolated between lines j and j + 1. Black borders are
  // excluded. is_black(i, j): pixel i of line j is black.
  const auto ranges_of = [](int lines, int size, const auto& is_black) {
    std::vector<Range> ranges;
    for (int j = 0; j < lines; ++j) {
      Range own = {0, size};
      while (own.begin < size && is_black(own.begin, j)) ++own.begin;
      while (own.end > own.begin && is_black(own.end - 1, j)) --own.end;
      --own.end;  // interpolation at i also reads pixel i + 1
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

template <typename V>
struct FrameColors::Samples {
  V color[3];
  V weight;  // 0: no colour, else 1
};

template <typename V>
struct FrameColors::Corners {
  float u[V::kCount], v[V::kCount];
  float is_seen[V::kCount];  // 0: a pixel is in a black border, else 1
  float color[4][3][V::kCount];
  float is_lit[4][V::kCount];  // 0: the pixel is black, else 1
};

SeenColor FrameColors::At(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  ColorBatch batch;
  batch.Add(point, normal);
  LookUp(&batch);
  return batch.Seen(0);
}

void FrameColors::LookUp(ColorBatch* batch) const {
  WithInstructions([&](auto instructions) {
    using V = Lanes<float, decltype(instructions)>;
    for (int first = 0; first < batch->count; first += V::kCount) LookUp<V>(first, batch);
  });
}

template <typename V>
void FrameColors::LookUp(int first, ColorBatch* batch) const {
  const auto load = [&](int i) { return V::Load(&batch->patch[i][first]); };
  const V x = load(0), y = load(1), z = load(2), nx = load(3), ny = load(4), nz = load(5);
  const V turn_x = turn_.x(), turn_y = turn_.y(), turn_z = turn_.z();
  const V way_x = turn_y * z - turn_z * y + V(velocity_.x());
  const V way_y = turn_z * x - turn_x * z + V(velocity_.y());
  const V way_z = turn_x * y - turn_y * x + V(velocity_.z());
  const V rho = V(1.f) / z, ray_x = x * rho, ray_y = y * rho;
  const V u = V(fx_) * ray_x + V(cx_), v = V(fy_) * ray_y + V(cy_);
  const V u_per_s = V(-fx_) * rho * (way_x - ray_x * way_z);
  const V v_per_s = V(-fy_) * rho * (way_y - ray_y * way_z);
  // The point is at row v + v_per_s t at time t. This row is captured at t0 + v_per_s t row_s. Both
  // times are equal.
  const V half_height = 0.5f * static_cast<float>(color_.height());
  const V t0 = V(middle_s_) + (v + V(0.5f) - half_height) * V(row_s_);
  const V t = t0 / Max(V(0.5f), V(1.f) - v_per_s * V(row_s_));
  const Samples<V> seen = Sample<V>(u + u_per_s * t, v + v_per_s * t);
  const V fineness = V(fx_) * rho / V(kPixelsPerMetre);
  const V along = nx * x + (ny * y + nz * z);
  const V cosine = abs(along) / sqrt(x * x + (y * y + z * z));
  const V blur2 = (u_per_s * u_per_s + v_per_s * v_per_s) * V(kBlur_s * kBlur_s);
  const V sharpness = fineness * fineness * cosine / ((V(1.f) + blur2) * (V(1.f) + blur2));
  for (int i = 0; i < 3; ++i) seen.color[i].Store(&batch->color[i][first]);
  Select(seen.weight > V(0.f), sharpness, V(0.f)).Store(&batch->weight[first]);
}

// Interpolates bilinearly. The weight is 0 outside the image and next to black borders. Other black
// pixels are ignored, unless all four pixels are black.
template <typename V>
FrameColors::Samples<V> FrameColors::Sample(const V& u, const V& v) const {
  const V zero = 0.f, one = 1.f;
  const V right = static_cast<float>(color_.width() - 1);
  const V bottom = static_cast<float>(color_.height() - 1);
  const auto inside =
      (u > V(-0.5f)) & (v > V(-0.5f)) & (u < right + V(0.5f)) & (v < bottom + V(0.5f));
  const V at_u = Select(inside, Min(Max(u, zero), right), zero);
  const V at_v = Select(inside, Min(Max(v, zero), bottom), zero);
  Corners<V> corners;
  ReadCorners(at_u, at_v, &corners);
  const V right_ratio = at_u - V::Load(corners.u), lower_ratio = at_v - V::Load(corners.v);
  const V left_ratio = one - right_ratio, upper_ratio = one - lower_ratio;
  const V shares[4] = {left_ratio * upper_ratio, right_ratio * upper_ratio,
                       left_ratio * lower_ratio, right_ratio * lower_ratio};
  Samples<V> seen;
  V sum;
  for (int c = 0; c < 4; ++c) {
    const V share = shares[c] * V::Load(corners.is_lit[c]);
    for (int i = 0; i < 3; ++i) seen.color[i] += share * V::Load(corners.color[c][i]);
    sum += share;
  }
  seen.weight = Select(inside, V::Load(corners.is_seen), zero);
  const auto is_colored = (seen.weight > zero) & (sum > zero);
  for (V& color : seen.color) color = Select(is_colored, color / sum, zero);
  return seen;
}

template <typename V>
void FrameColors::ReadCorners(const V& at_u, const V& at_v, Corners<V>* corners) const {
  const int width = color_.width(), height = color_.height();
  std::int32_t left[V::kCount], top[V::kCount];
  std::uint32_t pixels[4][V::kCount];
  at_u.StoreTruncated(left);
  at_v.StoreTruncated(top);
  for (int k = 0; k < V::kCount; ++k) {
    left[k] = std::min(left[k], width - 2);
    top[k] = std::min(top[k], height - 2);
    corners->u[k] = static_cast<float>(left[k]);
    corners->v[k] = static_cast<float>(top[k]);
  }
  static_assert(sizeof(Rgb8) == 3);
  for (int k = 0; k < V::kCount; ++k) {
    corners->is_seen[k] = rows_[top[k]].Has(left[k]) & columns_[left[k]].Has(top[k]) ? 1.f : 0.f;
    for (int row = 0; row < 2; ++row) {
      // Two neighbour pixels have six bytes. Both copies have four bytes, which start at bytes 0
      // and 2.
      const Rgb8* const two = color_.row(top[k] + row) + left[k];
      std::memcpy(&pixels[2 * row][k], &two[0].r, 4);
      std::memcpy(&pixels[2 * row + 1][k], &two[0].b, 4);
    }
  }
  for (int c = 0; c < 4; ++c) {
    for (int k = 0; k < V::kCount; ++k) {
      const std::uint32_t rgb = c % 2 == 0 ? pixels[c][k] & 0xffffffu : pixels[c][k] >> 8;
      for (int i = 0; i < 3; ++i) {
        corners->color[c][i][k] =
            static_cast<float>(static_cast<std::int32_t>(rgb >> (8 * i) & 255u));
      }
      corners->is_lit[c][k] = rgb != 0 ? 1.f : 0.f;
    }
  }
}

}  // namespace surfit
