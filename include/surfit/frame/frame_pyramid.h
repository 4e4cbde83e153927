#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Image of 3-vectors, with one contiguous plane per coordinate. Values are unspecified after
// Resize(). Indices are not checked.
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

// Vertex and normal map of one resolution, in the camera frame. All images have the size of
// `camera`, except an empty `intensity`. `noise`: noise of the depth sensor, in a model view of the
// sensor that is registered to the view.
struct FrameLevel {
  PinholeCamera camera;
  DepthNoise noise;
  VectorImage vertex;      // m; z = 0: missing
  VectorImage normal;      // unit length, towards the camera; (0, 0, 0): missing
  Image<float> intensity;  // 0: black, 1: white; NaN: unknown; empty image: none

  // No readout, and the default prior.
  DepthSensor sensor() const { return {camera, noise}; }
};

// Level 0 is the finest. Each further level has half the width and height, rounded down. Can be
// empty.
struct FramePyramid {
  std::vector<FrameLevel> levels;
};

// Model view: predicted depth and normals of the map at a pose. ModelRenderer leaves
// `surface.intensity` empty.
struct ModelView {
  static constexpr std::int32_t kNoSurfel = -1;

  Rigid3d world_from_view;
  FrameLevel surface;                // in the camera frame of the view
  Image<std::int32_t> surfel_index;  // ids in the map until its next change; kNoSurfel: no surface
};

// Grey value from 0 (black) to 1 (white), with the weights of ITU-R BT.601.
inline float GreyOf(Rgb8 color) {
  return (0.299f * color.r + 0.587f * color.g + 0.114f * color.b) / 255.f;
}

// Mean gradient magnitude per cell of cell x cell pixels, normalised to mean 0 and standard
// deviation 1 over the image. Gradients above four times the mean are clamped. Incomplete cells at
// the right and lower border are dropped. Requires cell >= 1 (not checked).
Image<float> GradientCells(const Image<Rgb8>& color, int cell);

// Means of blocks of 2 x 2 pixels. NaN if a pixel is NaN. An odd last column or row is dropped.
Image<float> HalfResolution(const Image<float>& fine);

// Sets the intensities of all levels from a colour image of the finest level. (0, 0, 0) is a
// missing colour and becomes NaN. Does nothing for an empty image. Throws if a size is wrong.
void AddIntensity(const Image<Rgb8>& color, FramePyramid* pyramid);

}  // namespace surfit
