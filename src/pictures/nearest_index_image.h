#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "surfit/core/image.h"

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
    // The bits of positive floats are ordered as the floats.
    std::uint32_t bits;
    std::memcpy(&bits, &depth, sizeof bits);
    const std::uint64_t key = std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(index);
    auto& nearest = keys_[static_cast<std::size_t>(v) * width_ + u];
    std::uint64_t seen = nearest.load(std::memory_order_relaxed);
    while (key < seen && !nearest.compare_exchange_weak(seen, key, std::memory_order_relaxed)) {
    }
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
  // Its lower half reads as kNothing.
  static constexpr std::uint64_t kFarthest = std::numeric_limits<std::uint64_t>::max();

  int width_;
  int height_;
  std::vector<std::atomic<std::uint64_t>> keys_;
};

}  // namespace surfit
