#pragma once

#include <string>

namespace surfit {

// Width and height in px.
struct ImageSize {
  int width = 0;
  int height = 0;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
  friend bool operator==(ImageSize a, ImageSize b) {
    return a.width == b.width && a.height == b.height;
  }
  friend bool operator!=(ImageSize a, ImageSize b) { return !(a == b); }
};

// Throws InputError naming `path` if either is below 1 or above 16384, so that a damaged header
// cannot ask for all memory.
void RequireUsualSize(ImageSize size, const std::string& path);

}  // namespace surfit
