#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "surfit/core/image.h"

namespace surfit {

// Oriented disc in the world frame.
struct Surfel {
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // m
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // unit length, towards the observer
  Rgb8 color;
  float radius_m = 0;
  float confidence = 0;         // sum of the weights of its observations
  std::int32_t first_seen = 0;  // frame index
  std::int32_t last_seen = 0;   // frame index
  bool at_edge = false;         // observed at depth edges only
  float color_weight = 0;       // sum of the weights of its colours; 0: no colour
  bool from_stereo = false;     // seen by colour images only: see FindUnmeasuredSurfaces()
};

// Rounds to 8 bits per channel.
inline Rgb8 ToRgb8(const Eigen::Vector3f& color) {
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::min(std::max(value, 0.f), 255.f) + 0.5f);
  };
  return {byte(color.x()), byte(color.y()), byte(color.z())};
}

// Positive floating-point number between 2^-20 and 2^12 in one or two bytes, with 5 exponent bits.
// Rounds down. Other positive values are clamped. 0 is exact; negative numbers and NaN become 0.
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
  static constexpr std::uint32_t kDropped = 28 - 8 * sizeof(Bits);           // of 23 mantissa bits
  static constexpr std::uint32_t kOffset = (127u - 20u) << (23 - kDropped);  // 2^-20
};

// Relative precision of 1/8. Weights of 16 and more do not grow by increments of 1, so a running
// average continues with a weight of 1/17.
using WeightByte = SmallFloat<std::uint8_t>;
// Relative precision of 0.05 %, for lengths in m.
using SmallLength = SmallFloat<std::uint16_t>;

// Number in [-1, 1] in steps of 1 / 32767. Other numbers are clamped. The rounding error of a unit
// vector is at most 0.03 mrad.
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

// Number from 0 to 65535 / kSteps in steps of 1 / kSteps, a power of two. Rounds to nearest, and
// clamps other numbers.
template <int kSteps>
class SmallNumber {
 public:
  static constexpr float kStep = 1.f / kSteps;

  static std::uint16_t From(float number) {
    const float steps = std::min(std::max(0.f, kSteps * number), 65535.f);
    return static_cast<std::uint16_t>(static_cast<std::int32_t>(steps + 0.5f));
  }
  static float ToFloat(std::uint16_t small) { return kStep * static_cast<float>(small); }
};

using SmallSum = SmallNumber<256>;           // below 256, for confidences
using SmallCoordinate = SmallNumber<65536>;  // below 1 m, in steps of 15 um

// Observation of a surfel by one frame: the average of its points.
struct SurfelObservation {
  // Average of the points that are accurate enough for the shape.
  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();  // m
  Eigen::Vector3f normal_in_world = Eigen::Vector3f::Zero();    // length of at most 1
  float radius_m = 0;                                           // minimum
  float shape_weight = 1;  // sum of the weights of these points; 0: none
  // Colour at the centre of the surfel.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  // sRGB, 0 to 255
  float color_weight = 1;                           // 0: no colour
  float weight = 1;                                 // a, sum of the weights of all points
  bool at_edge = false;                             // all points are at depth edges
};

// Conservative bounds of a set of surfels.
struct SurfelBounds {
  float low[3] = {kMost, kMost, kMost};  // of positions in the world, m
  float high[3] = {-kMost, -kMost, -kMost};
  float least_confidence = kMost;
  std::int32_t least_last_seen = std::numeric_limits<std::int32_t>::max();

  bool empty() const { return low[0] > high[0]; }
  void Add(const Eigen::Vector3f& position_in_world);
  void Add(const SurfelBounds& other);

 private:
  static constexpr float kMost = std::numeric_limits<float>::infinity();
};

// Up to kCapacity neighbouring surfels as structure of arrays, 29 bytes per surfel. The first
// `count` are in use. All numbers are finite, because loops process the whole block.
//
// Positions are relative to the corner `origin` of a cube of 1 m: the cell of the map, plus half a
// cell on each side. Positions outside of the cube are clamped.
struct SurfelBlock {
  static constexpr int kCapacity = 64;                      // one bit per surfel in a mask
  static constexpr std::int32_t kMaxFrame = (1 << 24) - 1;  // 6.5 days at 30 Hz

  std::uint64_t at_edge = 0;      // mask: observed at depth edges only
  std::uint64_t to_remove = 0;    // mask: see SurfelMap::RemoveMarked()
  std::uint64_t from_stereo = 0;  // mask: Surfel::from_stereo
  std::int32_t count = 0;
  std::int32_t cell = 0;  // index of its cell in the map
  SurfelBounds bounds;
  float origin[3] = {-0.5f, -0.5f, -0.5f};  // in the world, m

  std::uint16_t x[kCapacity] = {}, y[kCapacity] = {}, z[kCapacity] = {};    // SmallCoordinate
  std::int16_t nx[kCapacity] = {}, ny[kCapacity] = {}, nz[kCapacity] = {};  // SmallUnit: Normal()
  std::uint16_t radius[kCapacity] = {};      // SmallLength: Radius_m()
  std::uint16_t confidence[kCapacity] = {};  // SmallSum: Confidence()
  // Frame indices: the lower 16 bits and the upper 8 bits.
  std::uint16_t last_seen_low[kCapacity] = {};
  std::uint8_t last_seen_high[kCapacity] = {};
  std::uint16_t first_seen_low[kCapacity] = {};
  std::uint8_t first_seen_high[kCapacity] = {};
  // sRGB in units of 1/256 of an 8-bit step. The lowest bits store the WeightByte of the colour:
  // bits 0 to 2 in blue, 3 to 5 in green, 6 and 7 in red.
  std::uint16_t red[kCapacity] = {}, green[kCapacity] = {}, blue[kCapacity] = {};

  Surfel operator[](int k) const;
  float X(int k) const { return origin[0] + SmallCoordinate::ToFloat(x[k]); }  // in the world, m
  float Y(int k) const { return origin[1] + SmallCoordinate::ToFloat(y[k]); }
  float Z(int k) const { return origin[2] + SmallCoordinate::ToFloat(z[k]); }
  Eigen::Vector3f Position(int k) const { return {X(k), Y(k), Z(k)}; }
  void SetPosition(int k, const Eigen::Vector3f& position);
  // Unit length, up to the rounding of SmallUnit.
  Eigen::Vector3f Normal(int k) const;
  void SetNormal(int k, const Eigen::Vector3f& normal);
  float Radius_m(int k) const { return SmallLength::ToFloat(radius[k]); }
  void SetRadius_m(int k, float radius_m) { radius[k] = SmallLength::From(radius_m); }
  float Confidence(int k) const { return SmallSum::ToFloat(confidence[k]); }
  void SetConfidence(int k, float number) { confidence[k] = SmallSum::From(number); }
  std::int32_t FirstSeen(int k) const { return first_seen_high[k] << 16 | first_seen_low[k]; }
  void SetFirstSeen(int k, std::int32_t frame);  // 0 to kMaxFrame
  std::int32_t LastSeen(int k) const { return last_seen_high[k] << 16 | last_seen_low[k]; }
  void SetLastSeen(int k, std::int32_t frame);  // 0 to kMaxFrame
  Rgb8 Color(int k) const;
  // sRGB from 0 to 255, in steps of 1/32.
  Eigen::Vector3f FineColor(int k) const;
  float ColorWeight(int k) const;
  void SetColor(int k, const Eigen::Vector3f& color, float weight);  // 0 to 255, not clamped

  // Writes surfel k, without masks and bounds. Different surfels may be written in parallel.
  void Write(int k, const Surfel& surfel);
  // Updates at_edge, from_stereo and bounds for surfel k. Not thread-safe.
  void Announce(int k, const Surfel& surfel);
  // Replaces surfel k by surfel j of another block, with its at_edge and from_stereo bits, at this
  // position. Extends the bounds.
  void Take(int k, const SurfelBlock& other, int j, const Eigen::Vector3f& position);
  // The position as it would be stored.
  Eigen::Vector3f Rounded(const Eigen::Vector3f& position) const;

  // Averages surfel k (confidence w) with an observation of weight a. The confidence becomes w + a,
  // at most max_confidence. Position and normal move by the ratio shape_weight / (w + a). The
  // radius becomes the minimum of both, unless shape_weight is 0. Requires w + a > 0. The colour is
  // averaged by the colour weights. The at_edge bit is cleared unless the observation is at an
  // edge. Does not update the bounds or last_seen.
  void Merge(int k, const SurfelObservation& observation, float max_confidence);
};

// Inline for speed: fusion makes several hundred thousand calls per frame.
inline void SurfelBlock::SetPosition(int k, const Eigen::Vector3f& position) {
  x[k] = SmallCoordinate::From(position.x() - origin[0]);
  y[k] = SmallCoordinate::From(position.y() - origin[1]);
  z[k] = SmallCoordinate::From(position.z() - origin[2]);
}

inline void SurfelBlock::SetFirstSeen(int k, std::int32_t frame) {
  first_seen_low[k] = static_cast<std::uint16_t>(frame);
  first_seen_high[k] = static_cast<std::uint8_t>(frame >> 16);
}

inline void SurfelBlock::SetLastSeen(int k, std::int32_t frame) {
  last_seen_low[k] = static_cast<std::uint16_t>(frame);
  last_seen_high[k] = static_cast<std::uint8_t>(frame >> 16);
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
  const float weight = Confidence(k);
  const float inverse_sum = 1.f / (weight + seen.weight);
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
  SetConfidence(k, std::min(weight + seen.weight, max_confidence));
}

}  // namespace surfit
