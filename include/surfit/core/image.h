#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

namespace surfit {

// Allocator without initialisation: new elements of a plain type have unspecified values.
template <typename T>
struct RawAllocator : std::allocator<T> {
  using std::allocator<T>::allocator;
  // Replaces the rebind of std::allocator.
  template <typename U>
  struct rebind {
    using other = RawAllocator<U>;
  };
  template <typename U>
  void construct(U* element) {
    ::new (static_cast<void*>(element)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) U(std::forward<Arguments>(arguments)...);
  }
};

// Vector for large arrays. resize() leaves new elements unspecified.
template <typename T>
using RawVector = std::vector<T, RawAllocator<T>>;

// 8-bit sRGB colour.
struct Rgb8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  friend bool operator==(Rgb8 x, Rgb8 y) { return x.r == y.r && x.g == y.g && x.b == y.b; }
  friend bool operator!=(Rgb8 x, Rgb8 y) { return !(x == y); }
};

// Contiguous row-major image. u is the column in [0, width), v is the row in [0, height). Sizes
// must not be negative. Sizes and indices are not checked. A default-constructed image is empty.
template <typename T>
class Image {
 public:
  using value_type = T;

  Image() = default;
  Image(int width, int height, T fill = T{})
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height, fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return pixels_.size(); }
  bool empty() const { return pixels_.empty(); }

  // Changes the size. All pixel values are unspecified and pointers invalid afterwards.
  void Resize(int width, int height) {
    width_ = width;
    height_ = height;
    pixels_.resize(static_cast<std::size_t>(width) * height);
  }

  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T* row(int v) { return pixels_.data() + static_cast<std::size_t>(v) * width_; }
  const T* row(int v) const { return pixels_.data() + static_cast<std::size_t>(v) * width_; }
  T& operator()(int u, int v) { return row(v)[u]; }
  const T& operator()(int u, int v) const { return row(v)[u]; }
  T& operator[](std::size_t i) { return pixels_[i]; }
  const T& operator[](std::size_t i) const { return pixels_[i]; }

  auto begin() { return pixels_.begin(); }
  auto end() { return pixels_.end(); }
  auto begin() const { return pixels_.begin(); }
  auto end() const { return pixels_.end(); }

  friend bool operator==(const Image& a, const Image& b) {
    return a.width_ == b.width_ && a.height_ == b.height_ && a.pixels_ == b.pixels_;
  }

 private:
  int width_ = 0;
  int height_ = 0;
  RawVector<T> pixels_;
};

}  // namespace surfit
