#include "surfit/mapping/surfel_block.h"

namespace surfit {
namespace {

std::uint64_t Bit(int k) { return std::uint64_t{1} << k; }

}  // namespace

void SurfelBounds::Add(const Eigen::Vector3f& position) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], position[axis]);
    high[axis] = std::max(high[axis], position[axis]);
  }
}

void SurfelBounds::Add(const SurfelBounds& other) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
  least_confidence = std::min(least_confidence, other.least_confidence);
  least_last_seen = std::min(least_last_seen, other.least_last_seen);
}

Surfel SurfelBlock::operator[](int k) const {
  Surfel s;
  s.position_in_world = Position(k);
  s.normal_in_world = Normal(k);
  s.color = Color(k);
  s.radius_m = Radius_m(k);
  s.confidence = Confidence(k);
  s.first_seen = FirstSeen(k);
  s.last_seen = LastSeen(k);
  s.at_edge = (at_edge & Bit(k)) != 0;
  s.color_weight = ColorWeight(k);
  s.from_stereo = (from_stereo & Bit(k)) != 0;
  return s;
}

Rgb8 SurfelBlock::Color(int k) const { return ToRgb8(FineColor(k)); }

void SurfelBlock::Write(int k, const Surfel& s) {
  SetPosition(k, s.position_in_world);
  SetNormal(k, s.normal_in_world);
  SetColor(k, Eigen::Vector3f(s.color.r, s.color.g, s.color.b), s.color_weight);
  SetRadius_m(k, s.radius_m);
  SetConfidence(k, s.confidence);
  SetFirstSeen(k, s.first_seen);
  SetLastSeen(k, s.last_seen);
}

Eigen::Vector3f SurfelBlock::Rounded(const Eigen::Vector3f& position) const {
  Eigen::Vector3f rounded;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint16_t small = SmallCoordinate::From(position[axis] - origin[axis]);
    rounded[axis] = origin[axis] + SmallCoordinate::ToFloat(small);
  }
  return rounded;
}

void SurfelBlock::Announce(int k, const Surfel& s) {
  at_edge = s.at_edge ? at_edge | Bit(k) : at_edge & ~Bit(k);
  from_stereo = s.from_stereo ? from_stereo | Bit(k) : from_stereo & ~Bit(k);
  bounds.Add(Rounded(s.position_in_world));
  const float stored_confidence = SmallSum::ToFloat(SmallSum::From(s.confidence));
  bounds.least_confidence = std::min(bounds.least_confidence, stored_confidence);
  bounds.least_last_seen = std::min(bounds.least_last_seen, s.last_seen);
}

void SurfelBlock::Take(int k, const SurfelBlock& other, int j, const Eigen::Vector3f& position) {
  SetPosition(k, position);
  nx[k] = other.nx[j];
  ny[k] = other.ny[j];
  nz[k] = other.nz[j];
  radius[k] = other.radius[j];
  confidence[k] = other.confidence[j];
  SetFirstSeen(k, other.FirstSeen(j));
  SetLastSeen(k, other.LastSeen(j));
  red[k] = other.red[j];
  green[k] = other.green[j];
  blue[k] = other.blue[j];
  Surfel announced;
  announced.position_in_world = position;
  announced.confidence = Confidence(k);
  announced.last_seen = LastSeen(k);
  announced.at_edge = (other.at_edge & Bit(j)) != 0;
  announced.from_stereo = (other.from_stereo & Bit(j)) != 0;
  Announce(k, announced);
}

}  // namespace surfit
