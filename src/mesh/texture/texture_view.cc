#include "mesh/texture/texture_view.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "mesh/texture/triangle_pixels.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kVerticesPerTask = 8192, kTrianglesPerTask = 8192;
constexpr int kMargin_px = 3;             // range of mixed colours at depth edges and image borders
constexpr float kLeastCosine = 0.2f;      // between ray and normal
constexpr float kHidden_m = 0.03f;        // minimum depth behind an occluder
constexpr float kHiddenPerMetre = 0.03f;  // added to kHidden_m, per metre of depth
constexpr float kMissed_m = 0.1f;         // maximum difference to the measured depth
constexpr int kDark = 20, kBright = 245;
constexpr float kLossByBrightness = 0.7f;
constexpr float kBlur_s = 0.005f, kPixelsPerMetre = 500.f;  // values of FrameColors

template <typename T>
Image<T> MinAround(const Image<T>& image, int radius) {
  const int width = image.width(), height = image.height();
  Image<T> rows(width, height), least(width, height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const T* const row = image.row(v);
      for (int u = 0; u < width; ++u)
        rows(u, v) =
            *std::min_element(row + std::max(0, u - radius), row + std::min(width, u + radius + 1));
    }
  });
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      std::copy_n(rows.row(v), width, least.row(v));
      for (int w = std::max(0, v - radius); w < std::min(height, v + radius + 1); ++w)
        for (int u = 0; u < width; ++u) least(u, v) = std::min(least(u, v), rows(u, w));
    }
  });
  return least;
}

// Atomic minimum. The bits of positive floats have the order of their values.
void Lower(std::atomic<std::uint32_t>* bits, float value) {
  std::uint32_t lower = 0, seen = bits->load(std::memory_order_relaxed);
  std::memcpy(&lower, &value, sizeof(lower));
  while (lower < seen && !bits->compare_exchange_weak(seen, lower, std::memory_order_relaxed)) {
  }
}

Eigen::Vector2f PixelOf(const TextureCamera::Place& place) { return {place.u, place.v}; }

}  // namespace

TextureView::TextureView(const TriangleMesh& mesh, const TextureFrame& frame)
    : mesh_(mesh), frame_(frame), camera_(frame), places_(mesh.vertices.size()) {
  ParallelFor(0, static_cast<int>(places_.size()), kVerticesPerTask, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) places_[i] = camera_.See(mesh.vertices[i]);
  });
  DrawDepths();
  FindClearPixels();
  sharpness_.resize(mesh.triangles.size());
  ParallelFor(0, static_cast<int>(sharpness_.size()), kTrianglesPerTask, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) sharpness_[i] = SharpnessOf(mesh.triangles[i]);
  });
  FindGain();
}

void TextureView::DrawDepths() {
  const int width = frame_.camera.width, height = frame_.camera.height;
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  std::vector<std::atomic<std::uint32_t>> bits(static_cast<std::size_t>(width) * height);
  std::uint32_t nothing = 0;
  std::memcpy(&nothing, &kNothing, sizeof(nothing));
  for (auto& pixel : bits) pixel.store(nothing, std::memory_order_relaxed);
  ParallelFor(
      0, static_cast<int>(mesh_.triangles.size()), kTrianglesPerTask, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
          const Triangle& t = mesh_.triangles[i];
          const auto &a = places_[t[0]], &b = places_[t[1]], &c = places_[t[2]];
          if (a.z == 0 || b.z == 0 || c.z == 0) continue;
          const Eigen::Vector3f rho(1 / a.z, 1 / b.z, 1 / c.z);
          VisitPixels(PixelOf(a), PixelOf(b), PixelOf(c), width, height,
                      [&](int u, int v, const Eigen::Vector3f& shares) {
                        Lower(&bits[static_cast<std::size_t>(v) * width + u], 1 / rho.dot(shares));
                      });
        }
      });
  Image<float> depths_m(width, height);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const std::uint32_t value = bits[i];
    std::memcpy(&depths_m[i], &value, sizeof(value));
  }
  nearest_m_ = MinAround(depths_m, kMargin_px);
}

void TextureView::FindClearPixels() {
  const Image<Rgb8>& color = frame_.frame.color;
  Image<std::uint8_t> has_color(color.width(), color.height());
  for (int v = kMargin_px; v < color.height() - kMargin_px; ++v)
    for (int u = kMargin_px; u < color.width() - kMargin_px; ++u)
      has_color(u, v) = color(u, v) != Rgb8() ? 1 : 0;
  is_clear_ = MinAround(has_color, 1);
}

bool TextureView::IsClearAt(float u, float v, float z) const {
  const int at_u = static_cast<int>(std::floor(u + 0.5f));
  const int at_v = static_cast<int>(std::floor(v + 0.5f));
  if (at_u < 0 || at_v < 0 || at_u >= is_clear_.width() || at_v >= is_clear_.height()) return false;
  if (is_clear_(at_u, at_v) == 0) return false;
  const float margin_m = kHiddenPerMetre * z, measured_m = frame_.frame.depth_m(at_u, at_v);
  if (z > nearest_m_(at_u, at_v) + kHidden_m + margin_m) return false;
  return !(measured_m > 0) || std::abs(z - measured_m) < kMissed_m + margin_m;
}

bool TextureView::IsClear(const Triangle& triangle) const {
  const auto &a = places_[triangle[0]], &b = places_[triangle[1]], &c = places_[triangle[2]];
  for (const auto* place : {&a, &b, &c}) {
    if (place->z == 0 || !IsClearAt(place->u, place->v, place->z)) return false;
  }
  bool is_clear = true;
  const Eigen::Vector3f rho(1 / a.z, 1 / b.z, 1 / c.z);
  VisitPixels(PixelOf(a), PixelOf(b), PixelOf(c), is_clear_.width(), is_clear_.height(),
              [&](int u, int v, const Eigen::Vector3f& shares) {
                is_clear = is_clear && IsClearAt(static_cast<float>(u), static_cast<float>(v),
                                                 1 / rho.dot(shares));
              });
  return is_clear;
}

float TextureView::SharpnessOf(const Triangle& triangle) const {
  if (!IsClear(triangle)) return 0;
  const Eigen::Vector3f &a = mesh_.vertices[triangle[0]], &b = mesh_.vertices[triangle[1]],
                        &c = mesh_.vertices[triangle[2]];
  const Eigen::Vector3f own = (b - a).cross(c - a), ray = camera_.center() - (a + b + c) / 3;
  // Sum of the vertex normals. It is smoother than the triangle normal `own`.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float z = 0, speed = 0, bright = 0;
  for (const std::uint32_t v : triangle) {
    normal += mesh_.normals[v];
    z += places_[v].z / 3;
    speed += places_[v].speed / 3;
    const Rgb8 color = ColorOf(v);
    bright += std::max({color.r, color.g, color.b}) > kBright ? 1.f / 3 : 0;
  }
  const float cosine = normal.dot(ray) / (normal.norm() * ray.norm());
  if (!(own.dot(ray) > 0 && cosine > kLeastCosine)) return 0;
  const float fineness = camera_.fx() / z / kPixelsPerMetre, blur = speed * kBlur_s;
  const float sharp = 1 + blur * blur;
  return fineness * fineness * cosine / (sharp * sharp) * (1 - kLossByBrightness * bright);
}

Rgb8 TextureView::ColorOf(std::uint32_t vertex) const {
  const TextureCamera::Place& place = places_[vertex];
  return frame_.frame.color(static_cast<int>(place.u + 0.5f), static_cast<int>(place.v + 0.5f));
}

// Sets the gain per channel: mesh colour divided by frame colour, summed over visible triangles.
// Dark and overexposed colours are excluded.
void TextureView::FindGain() {
  constexpr int kFewest = 100;
  struct Sums {
    Eigen::Vector3d of_mesh = Eigen::Vector3d::Zero(), of_frame = Eigen::Vector3d::Zero();
    int count = 0;
    Sums& operator+=(const Sums& other) {
      of_mesh += other.of_mesh;
      of_frame += other.of_frame;
      count += other.count;
      return *this;
    }
  };
  const int count = static_cast<int>(mesh_.triangles.size());
  const Sums sums = ParallelSum(0, count, kTrianglesPerTask, Sums(), [&](int begin, int end) {
    Sums part;
    for (int i = begin; i < end; ++i) {
      if (!(sharpness_[i] > 0)) continue;
      const std::uint32_t v = mesh_.triangles[i][0];
      const Rgb8 seen = ColorOf(v);
      const auto [low, high] = std::minmax({seen.r, seen.g, seen.b});
      if (low < kDark || high > kBright) continue;
      const Rgb8 own = mesh_.colors[v];
      part.of_mesh += Eigen::Vector3d(own.r, own.g, own.b);
      part.of_frame += Eigen::Vector3d(seen.r, seen.g, seen.b);
      ++part.count;
    }
    return part;
  });
  if (sums.count < kFewest) return;
  gain_ = sums.of_mesh.cwiseQuotient(sums.of_frame).cwiseMax(0.5).cwiseMin(2).cast<float>();
}

}  // namespace surfit
