#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// One surfel: an oriented disc, in the world frame.
struct Surfel {
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // unit length, towards the observer
  Rgb8 color;
  float radius_m = 0;
  float confidence = 0;         // sum of the weights of its observations
  std::int32_t first_seen = 0;  // frame index
  std::int32_t last_seen = 0;   // frame index
};

// The fused map as structure of arrays, all of size().
class SurfelMap {
 public:
  std::size_t size() const { return x.size(); }
  void Reserve(std::size_t count);
  void Append(const Surfel& surfel);
  Surfel operator[](std::size_t i) const;
  void Set(std::size_t i, const Surfel& surfel);
  // Removes the surfels with keep[i] == 0 and keeps the order of the others; returns how many.
  std::size_t Compact(const std::vector<std::uint8_t>& keep);

  std::vector<float> x, y, z;                   // position in the world, metres
  std::vector<float> nx, ny, nz;                // unit normal in the world
  std::vector<std::uint16_t> red, green, blue;  // sRGB in 1/256 of an 8-bit step
  std::vector<float> radius_m;
  std::vector<float> confidence;
  std::vector<std::int32_t> first_seen, last_seen;  // frame index
};

}  // namespace surfit
