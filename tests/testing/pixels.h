#pragma once

#include "surfit/geometry/pinhole_camera.h"

namespace surfit::testing {

// Pixels of a rectangle in row-major order: for (const auto [u, v] : PixelsOf(image)).
class Pixels {
 public:
  Pixels(int u_begin, int u_end, int v_begin, int v_end)
      : u_begin_(u_begin), u_end_(u_end), v_begin_(v_begin), v_end_(v_end) {}

  struct Pixel {
    int u = 0, v = 0;
  };
  struct Iterator {
    const Pixels& pixels;
    Pixel at;
    Pixel operator*() const { return at; }
    bool operator!=(const Iterator& other) const { return at.v != other.at.v; }
    void operator++() {
      if (++at.u == pixels.u_end_) at = {pixels.u_begin_, at.v + 1};
    }
  };
  Iterator begin() const { return {*this, {u_begin_, u_begin_ < u_end_ ? v_begin_ : v_end_}}; }
  Iterator end() const { return {*this, {u_begin_, v_end_}}; }

 private:
  int u_begin_, u_end_, v_begin_, v_end_;
};

inline Pixels PixelsOf(int width, int height) { return {0, width, 0, height}; }
inline Pixels PixelsOf(const PinholeCamera& camera) { return {0, camera.width, 0, camera.height}; }
template <typename AnyImage>
Pixels PixelsOf(const AnyImage& image) {
  return {0, image.width(), 0, image.height()};
}

}  // namespace surfit::testing
