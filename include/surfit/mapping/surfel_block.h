#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

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
  float color_weight = 0;       // sum of the weights of its colours; 0 without any
};

// The nearest colour, of 8-bit steps.
inline Rgb8 ToRgb8(const Eigen::Vector3f& color) {
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::min(std::max(value, 0.f), 255.f) + 0.5f);
  };
  return {byte(color.x()), byte(color.y()), byte(color.z())};
}

// A number from 2^-20 to 2^12 in few bits: five of a power of two, the others of what is between,
// rounded down; 0 is none.
template <typename Bits>
class SmallFloat {
 public:
  static Bits From(float number) {
    std::uint32_t bits;
    std::memcpy(&bits, &number, sizeof(bits));
    const std::uint32_t some = std::clamp(bits >> kDropped, kOffset + 1, kOffset + kMost) - kOffset;
    return static_cast<Bits>(number > 0.f ? some : 0);
  }
  static float ToFloat(Bits small) {
    const std::uint32_t bits = small == 0 ? 0 : (small + kOffset) << kDropped;
    float number;
    std::memcpy(&number, &bits, sizeof(number));
    return number;
  }

 private:
  static constexpr std::uint32_t kMost = std::numeric_limits<Bits>::max();
  static constexpr std::uint32_t kDropped = 28 - 8 * sizeof(Bits);  // of 23 between two powers
  static constexpr std::uint32_t kOffset = (127u - 20u) << (23 - kDropped);  // 2^-20
};

// To an eighth: a sum of equal weights ends at 16 of them, and an average by it goes on with a
// share of a seventeenth.
using WeightByte = SmallFloat<std::uint8_t>;
// To .05 % of a length in metres.
using SmallLength = SmallFloat<std::uint16_t>;

// A number from -1 to 1 to the nearest 1 / 32767. So a unit vector turns by .03 mrad at most.
class SmallUnit {
 public:
  static std::int16_t From(float number) {
    const float within = std::min(std::max(-1.f, number), 1.f);
    return static_cast<std::int16_t>(static_cast<std::int32_t>(kSteps * within + 32768.5f) - 32768);
  }
  static float ToFloat(std::int16_t small) { return static_cast<float>(small) * (1.f / kSteps); }

 private:
  static constexpr float kSteps = 32767.f;
};

// What a frame has measured of a surfel: the average of its points there.
struct SurfelObservation {
  // Of those points that its shape can gain from.
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // not longer than one
  float radius_m = 0;                                           // the least
  float shape_weight = 1;                                       // the sum of their weights, or 0
  // Of what the frame shows where the surfel lies.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  // sRGB, in 8-bit steps
  float color_weight = 1;                           // 0 without a colour
  float weight = 1;                                 // a, the sum
  bool at_edge = false;                             // at depth edges, with normals of neighbours
};

// What is known of all surfels of a set without looking at them: bounds, which hold but need not be
// tight.
struct SurfelBounds {
  float low[3] = {kMost, kMost, kMost};  // of positions in the world, metres
  float high[3] = {-kMost, -kMost, -kMost};
  float least_confidence = kMost;
  std::int32_t least_last_seen = std::numeric_limits<std::int32_t>::max();

  bool empty() const { return low[0] > high[0]; }
  void Add(const Eigen::Vector3f& position_in_world);
  void Add(const SurfelBounds& other);

 private:
  static constexpr float kMost = std::numeric_limits<float>::infinity();
};

// Up to kCapacity surfels that are close together, as structure of arrays: 39 bytes each. The first
// `count` are in use; the others hold finite numbers.
struct SurfelBlock {
  static constexpr int kCapacity = 64;  // one bit each in a mask

  std::uint64_t at_edge = 0;    // mask: no observation yet but at depth edges
  std::uint64_t to_remove = 0;  // mask: see SurfelMap::RemoveMarked()
  std::int32_t count = 0;
  std::int32_t cell = 0;  // of the map, that it belongs to
  SurfelBounds bounds;

  float x[kCapacity] = {}, y[kCapacity] = {}, z[kCapacity] = {};  // position in the world, metres
  std::int16_t nx[kCapacity] = {}, ny[kCapacity] = {}, nz[kCapacity] = {};  // SmallUnit: Normal()
  std::uint16_t radius[kCapacity] = {};  // SmallLength: Radius_m()
  float confidence[kCapacity] = {};
  std::int32_t first_seen[kCapacity] = {}, last_seen[kCapacity] = {};  // frame index
  // sRGB in 1/256 of an 8-bit step, of which the three last bits are other things: together, those
  // of blue first, the WeightByte of the colour.
  std::uint16_t red[kCapacity] = {}, green[kCapacity] = {}, blue[kCapacity] = {};

  Surfel operator[](int k) const;
  Eigen::Vector3f Position(int k) const { return {x[k], y[k], z[k]}; }
  void SetPosition(int k, const Eigen::Vector3f& position);
  // Of unit length, but for .03 mrad along each axis.
  Eigen::Vector3f Normal(int k) const;
  void SetNormal(int k, const Eigen::Vector3f& normal);
  float Radius_m(int k) const { return SmallLength::ToFloat(radius[k]); }
  void SetRadius_m(int k, float radius_m) { radius[k] = SmallLength::From(radius_m); }
  Rgb8 Color(int k) const;
  // In 8-bit steps, finer than these; and the weight that it has.
  Eigen::Vector3f FineColor(int k) const;
  float ColorWeight(int k) const;
  void SetColor(int k, const Eigen::Vector3f& color, float weight);

  // Writes surfel k. Different ones may be written at the same time.
  void Write(int k, const Surfel& surfel);
  // Does the rest for a surfel that is, or will be, written: the mask and the bounds.
  void Announce(int k, const Surfel& surfel);
  // Takes surfel j of another block as surfel k.
  void Take(int k, const SurfelBlock& other, int j);

  // The weighted average of surfel k with an observation of weight a: position, normal and colour
  // become (w q + a p) / (w + a), w the confidence; the normal is unit again, the radius the
  // smaller of both, and w becomes w + a, but at most max_confidence. Position and normal follow
  // the observation's only by its shape_weight; without any they stay, and so does the radius. The
  // colour is averaged likewise by the weights of colours. The bounds stay as they are.
  void Merge(int k, const SurfelObservation& observation, float max_confidence);
};

// Here, as fusion does it hundreds of thousands of times a frame.
inline void SurfelBlock::SetPosition(int k, const Eigen::Vector3f& position) {
  x[k] = position.x();
  y[k] = position.y();
  z[k] = position.z();
}

inline Eigen::Vector3f SurfelBlock::Normal(int k) const {
  return {SmallUnit::ToFloat(nx[k]), SmallUnit::ToFloat(ny[k]), SmallUnit::ToFloat(nz[k])};
}

inline void SurfelBlock::SetNormal(int k, const Eigen::Vector3f& normal) {
  nx[k] = SmallUnit::From(normal.x());
  ny[k] = SmallUnit::From(normal.y());
  nz[k] = SmallUnit::From(normal.z());
}

inline Eigen::Vector3f SurfelBlock::FineColor(int k) const {
  constexpr int kBits = ~7;
  return Eigen::Vector3f(static_cast<float>(red[k] & kBits), static_cast<float>(green[k] & kBits),
                         static_cast<float>(blue[k] & kBits)) /
         256.f;
}

inline float SurfelBlock::ColorWeight(int k) const {
  const int byte = (blue[k] & 7) | (green[k] & 7) << 3 | (red[k] & 3) << 6;
  return WeightByte::ToFloat(static_cast<std::uint8_t>(byte));
}

inline void SurfelBlock::SetColor(int k, const Eigen::Vector3f& color, float weight) {
  const unsigned byte = WeightByte::From(weight);
  const auto packed = [](float value, unsigned bits) {
    return static_cast<std::uint16_t>(static_cast<unsigned>(32.f * value + 0.5f) << 3 | bits);
  };
  red[k] = packed(color.x(), byte >> 6);
  green[k] = packed(color.y(), byte >> 3 & 7u);
  blue[k] = packed(color.z(), byte & 7u);
}

inline void SurfelBlock::Merge(int k, const SurfelObservation& seen, float max_confidence) {
  // (w q + a p) / (w + a) = q + a / (w + a) (p - q)
  const float inverse_sum = 1.f / (confidence[k] + seen.weight);
  if (seen.shape_weight > 0.f) {
    const float share = seen.shape_weight * inverse_sum;
    const Eigen::Vector3f p = Position(k), n = Normal(k);
    SetPosition(k, p + share * (seen.position_in_world - p));
    SetNormal(k, (n + share * (seen.normal_in_world - n)).normalized());
    SetRadius_m(k, std::min(Radius_m(k), seen.radius_m));
  }
  if (seen.color_weight > 0.f) {
    const float sum = ColorWeight(k) + seen.color_weight;
    const Eigen::Vector3f before = FineColor(k);
    SetColor(k, before + seen.color_weight / sum * (seen.color - before), sum);
  }
  if (!seen.at_edge) at_edge &= ~(std::uint64_t{1} << k);
  confidence[k] = std::min(confidence[k] + seen.weight, max_confidence);
}

}  // namespace surfit
