#pragma once

#include <vector>

#include "surfit/frame/vector_image.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

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

}  // namespace surfit
