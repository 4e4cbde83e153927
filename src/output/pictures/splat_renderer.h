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

// A z-buffer: keeps for each pixel the index of the nearest thing offered there, of equally near
// ones the lowest index. The result does not depend on the order of the offers.
class NearestIndexImage {
 public:
  static constexpr std::int32_t kNothing = -1;

  NearestIndexImage(int width, int height)
      : width_(width), height_(height), keys_(static_cast<std::size_t>(width) * height) {
    for (auto& key : keys_) key.store(kFarthest, std::memory_order_relaxed);
  }

  int width() const { return width_; }
  int height() const { return height_; }

  // Thread-safe. depth > 0; (u, v) inside the image.
  void Offer(int u, int v, float depth, std::int32_t index) {
    const std::uint64_t key = Key(depth, index);
    auto& nearest = keys_[static_cast<std::size_t>(v) * width_ + u];
    std::uint64_t seen = nearest.load(std::memory_order_relaxed);
    while (key < seen && !nearest.compare_exchange_weak(seen, key, std::memory_order_relaxed)) {
    }
  }

  // Whether something nearer than the depth is there already, so that an offer would be in vain.
  bool IsHidden(int u, int v, float depth) const {
    const auto& nearest = keys_[static_cast<std::size_t>(v) * width_ + u];
    return nearest.load(std::memory_order_relaxed) < Key(depth, 0);
  }

  // kNothing where nothing was offered.
  Image<std::int32_t> Indices() const {
    Image<std::int32_t> indices(width_, height_);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      indices[i] = static_cast<std::int32_t>(keys_[i].load(std::memory_order_relaxed));
    }
    return indices;
  }

 private:
  // Ordered by depth, then by index: the bits of positive floats are ordered as the floats.
  static std::uint64_t Key(float depth, std::int32_t index) {
    std::uint32_t bits;
    std::memcpy(&bits, &depth, sizeof bits);
    return std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(index);
  }

  // Its lower half reads as kNothing.
  static constexpr std::uint64_t kFarthest = std::numeric_limits<std::uint64_t>::max();

  int width_;
  int height_;
  std::vector<std::atomic<std::uint64_t>> keys_;
};

// The id of the surfel that each pixel of the view sees, NearestIndexImage::kNothing where none.
// Surfels are opaque discs: a pixel is covered where its ray meets the disc, and so is the pixel
// that holds the projected centre, so that none is lost between pixels. Surfels with shown[id] ==
// 0, those that face away from the camera and those nearer than two radii are not drawn.
Image<std::int32_t> RenderSurfels(const SurfelMap& map, const std::vector<std::uint8_t>& shown,
                                  const PictureView& view);

// The index of the point that each pixel sees; a point covers size_px x size_px pixels about its
// projection. Points are in the view's world.
Image<std::int32_t> RenderPoints(const std::vector<Eigen::Vector3f>& points_in_world, int size_px,
                                 const PictureView& view);

}  // namespace surfit
