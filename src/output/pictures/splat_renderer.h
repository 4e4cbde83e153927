#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "output/pictures/picture_view.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Z-buffer of indices. Each pixel keeps the index with the smallest depth, and the lowest index for
// equal depths. The result does not depend on the order of calls.
class NearestIndexImage {
 public:
  static constexpr std::int32_t kNothing = -1;

  NearestIndexImage(int width, int height)
      : width_(width), height_(height), keys_(static_cast<std::size_t>(width) * height) {
    for (auto& key : keys_) key.store(kFarthest, std::memory_order_relaxed);
  }

  int width() const { return width_; }
  int height() const { return height_; }

  // Writes the pixel if `depth` is nearer than the stored depth. Thread-safe. Requires depth > 0,
  // index >= 0 and (u, v) inside the image.
  void Offer(int u, int v, float depth, std::int32_t index) {
    const std::uint64_t key = Key(depth, index);
    auto& nearest = keys_[static_cast<std::size_t>(v) * width_ + u];
    std::uint64_t seen = nearest.load(std::memory_order_relaxed);
    while (key < seen && !nearest.compare_exchange_weak(seen, key, std::memory_order_relaxed)) {
    }
  }

  // True if the stored depth is smaller than `depth`: Offer() with any index would have no effect.
  // Thread-safe.
  bool IsHidden(int u, int v, float depth) const {
    const auto& nearest = keys_[static_cast<std::size_t>(v) * width_ + u];
    return nearest.load(std::memory_order_relaxed) < Key(depth, 0);
  }

  // Index of each pixel; kNothing for pixels without Offer().
  Image<std::int32_t> Indices() const {
    Image<std::int32_t> indices(width_, height_);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      indices[i] = static_cast<std::int32_t>(keys_[i].load(std::memory_order_relaxed));
    }
    return indices;
  }

 private:
  // Key ordered by depth, then by index. Bit patterns of positive floats have the order of the
  // floats.
  static std::uint64_t Key(float depth, std::int32_t index) {
    std::uint32_t bits;
    std::memcpy(&bits, &depth, sizeof bits);
    return std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(index);
  }

  static constexpr std::uint64_t kFarthest = std::numeric_limits<std::uint64_t>::max();

  int width_;
  int height_;
  std::vector<std::atomic<std::uint64_t>> keys_;
};

// Renders the id of the visible surfel of each pixel; NearestIndexImage::kNothing without surfel.
// Surfels are opaque discs, and cover at least the pixel of their centre. Back faces, surfels with
// shown[id] == 0, and surfels nearer than two radii are not drawn. `shown` has one value per id
// below SurfelMap::id_end(), 0 for unused ids. Requires fx = fy. Distortion is ignored.
Image<std::int32_t> RenderSurfels(const SurfelMap& map, const std::vector<std::uint8_t>& shown,
                                  const PictureView& view);

// Renders the index of the nearest point of each pixel; NearestIndexImage::kNothing without point.
// A point covers size_px x size_px pixels. Points behind the camera are not drawn. Requires finite
// points and fx = fy. Distortion is ignored.
Image<std::int32_t> RenderPoints(const std::vector<Eigen::Vector3f>& points_in_world, int size_px,
                                 const PictureView& view);

}  // namespace surfit
