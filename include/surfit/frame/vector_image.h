#pragma once

#include <Eigen/Core>

#include "surfit/core/image.h"

namespace surfit {

// An image of 3-vectors, one contiguous plane for each coordinate.
struct VectorImage {
  Image<float> x, y, z;

  VectorImage() = default;
  VectorImage(int width, int height)
      : x(width, height, 0.f), y(width, height, 0.f), z(width, height, 0.f) {}

  int width() const { return x.width(); }
  int height() const { return x.height(); }
  void Resize(int width, int height) {
    x.Resize(width, height);
    y.Resize(width, height);
    z.Resize(width, height);
  }
  Eigen::Vector3f operator()(int u, int v) const { return {x(u, v), y(u, v), z(u, v)}; }
  void Set(int u, int v, const Eigen::Vector3f& value) {
    x(u, v) = value.x();
    y(u, v) = value.y();
    z(u, v) = value.z();
  }
};

}  // namespace surfit
