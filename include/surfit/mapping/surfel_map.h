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
  bool at_edge = false;         // no observation yet but at depth edges
};

// A measured point that is to be merged with a surfel.
struct SurfelObservation {
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // unit length
  Rgb8 color;
  float radius_m = 0;
  float weight = 1;      // a
  bool at_edge = false;  // at a depth edge, with the normal of a neighbour
};

// The fused map as structure of arrays, all of size().
class SurfelMap {
 public:
  std::size_t size() const { return x.size(); }
  void Reserve(std::size_t count);
  void Append(const Surfel& surfel);
  Surfel operator[](std::size_t i) const;
  Rgb8 Color(std::size_t i) const;
  void Set(std::size_t i, const Surfel& surfel);

  // The weighted average of surfel i with an observation of weight a: position, normal and colour
  // become (w q + a p) / (w + a), w the confidence; the normal is unit again, the radius the
  // smaller of both, and w becomes w + a, but at most max_confidence. Without `refine` position,
  // normal and radius stay: the observation cannot improve them.
  void Merge(std::size_t i, const SurfelObservation& observation, bool refine,
             float max_confidence);

  // Removes the surfels with remove[i] != 0 and adds others. The added ones take the places of the
  // removed, in order; what stays empty is filled from the end. Returns how many were removed.
  std::size_t Replace(const std::vector<std::uint8_t>& remove, const std::vector<Surfel>& added);

  std::vector<float> x, y, z;                   // position in the world, metres
  std::vector<float> nx, ny, nz;                // unit normal in the world
  std::vector<std::uint16_t> red, green, blue;  // sRGB in 1/256 of an 8-bit step
  std::vector<float> radius_m;
  std::vector<float> confidence;
  std::vector<std::int32_t> first_seen, last_seen;  // frame index
  std::vector<std::uint8_t> at_edge;                // 1 = no observation yet but at depth edges

 private:
  void FillFromTheEnd(const std::vector<std::size_t>& holes);
};

}  // namespace surfit
