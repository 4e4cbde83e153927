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
  s.confidence = confidence[k];
  s.first_seen = first_seen[k];
  s.last_seen = last_seen[k];
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
  confidence[k] = s.confidence;
  first_seen[k] = s.first_seen;
  last_seen[k] = s.last_seen;
}

void SurfelBlock::Announce(int k, const Surfel& s) {
  at_edge = s.at_edge ? at_edge | Bit(k) : at_edge & ~Bit(k);
  from_stereo = s.from_stereo ? from_stereo | Bit(k) : from_stereo & ~Bit(k);
  bounds.Add(s.position_in_world);
  bounds.least_confidence = std::min(bounds.least_confidence, s.confidence);
  bounds.least_last_seen = std::min(bounds.least_last_seen, s.last_seen);
}

void SurfelBlock::Take(int k, const SurfelBlock& other, int j) {
  x[k] = other.x[j];
  y[k] = other.y[j];
  z[k] = other.z[j];
  nx[k] = other.nx[j];
  ny[k] = other.ny[j];
  nz[k] = other.nz[j];
  radius[k] = other.radius[j];
  confidence[k] = other.confidence[j];
  first_seen[k] = other.first_seen[j];
  last_seen[k] = other.last_seen[j];
  red[k] = other.red[j];
  green[k] = other.green[j];
  blue[k] = other.blue[j];
  Surfel announced;
  announced.position_in_world = Position(k);
  announced.confidence = confidence[k];
  announced.last_seen = last_seen[k];
  announced.at_edge = (other.at_edge & Bit(j)) != 0;
  announced.from_stereo = (other.from_stereo & Bit(j)) != 0;
  Announce(k, announced);
}

}  // namespace surfit
