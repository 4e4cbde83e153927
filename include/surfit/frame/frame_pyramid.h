#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"

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

// Vertex and normal map of one resolution, both in the frame of the camera that sees them, how
// exact the depth sensor is whose measurements they come from or are to be compared with, and how
// bright these pixels are where anybody asks (AddIntensity).
struct FrameLevel {
  PinholeCamera camera;
  DepthNoise noise;
  VectorImage vertex;      // metres; z = 0 where missing
  VectorImage normal;      // unit length, facing the camera; (0, 0, 0) where missing
  Image<float> intensity;  // grey, 0 = black, 1 = white; NaN where unknown; empty = none

  DepthSensor sensor() const { return {camera, noise}; }
};

// Level 0 is the finest; each further one has half the width and height.
struct FramePyramid {
  std::vector<FrameLevel> levels;
};

// What the map predicts a camera sees from a pose: where mapping and registration meet.
struct ModelView {
  static constexpr std::int32_t kNoSurfel = -1;

  Rigid3d world_from_view;
  FrameLevel surface;                // in the view's camera frame
  Image<std::int32_t> surfel_index;  // ids in the map; kNoSurfel where nothing is seen
};

// Grey value of a colour from 0 (black) to 1 (white), with the weights of ITU-R BT.601.
inline float GreyOf(Rgb8 color) {
  return (0.299f * color.r + 0.587f * color.g + 0.114f * color.b) / 255.f;
}

// The mean of each block of 2 x 2 pixels; NaN where one of them is.
Image<float> HalfResolution(const Image<float>& fine);

// Gives all levels their intensities from the colours of the finest level's pixels, each level from
// the one before. (0, 0, 0) is no colour. Nothing is done where the colour image is empty.
void AddIntensity(const Image<Rgb8>& color, FramePyramid* pyramid);

}  // namespace surfit
