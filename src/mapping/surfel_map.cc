#include "surfit/mapping/surfel_map.h"

#include <glog/logging.h>

#include <algorithm>

namespace surfit {
namespace {

std::uint8_t ToByte(std::uint16_t value) {
  return static_cast<std::uint8_t>(std::min(255, (value + 128) >> 8));
}

std::uint16_t FromByte(std::uint8_t value) { return static_cast<std::uint16_t>(value << 8); }

// Calls f on each array of the map.
template <typename Map, typename F>
void ForEachArray(Map& m, const F& f) {
  f(m.x), f(m.y), f(m.z), f(m.nx), f(m.ny), f(m.nz);
  f(m.red), f(m.green), f(m.blue);
  f(m.radius_m), f(m.confidence), f(m.first_seen), f(m.last_seen);
}

}  // namespace

void SurfelMap::Reserve(std::size_t count) {
  ForEachArray(*this, [&](auto& array) { array.reserve(count); });
}

void SurfelMap::Append(const Surfel& surfel) {
  ForEachArray(*this, [&](auto& array) { array.emplace_back(); });
  Set(size() - 1, surfel);
}

Surfel SurfelMap::operator[](std::size_t i) const {
  Surfel s;
  s.position_in_world = {x[i], y[i], z[i]};
  s.normal_in_world = {nx[i], ny[i], nz[i]};
  s.color = {ToByte(red[i]), ToByte(green[i]), ToByte(blue[i])};
  s.radius_m = radius_m[i];
  s.confidence = confidence[i];
  s.first_seen = first_seen[i];
  s.last_seen = last_seen[i];
  return s;
}

void SurfelMap::Set(std::size_t i, const Surfel& s) {
  x[i] = s.position_in_world.x();
  y[i] = s.position_in_world.y();
  z[i] = s.position_in_world.z();
  nx[i] = s.normal_in_world.x();
  ny[i] = s.normal_in_world.y();
  nz[i] = s.normal_in_world.z();
  red[i] = FromByte(s.color.r);
  green[i] = FromByte(s.color.g);
  blue[i] = FromByte(s.color.b);
  radius_m[i] = s.radius_m;
  confidence[i] = s.confidence;
  first_seen[i] = s.first_seen;
  last_seen[i] = s.last_seen;
}

std::size_t SurfelMap::Compact(const std::vector<std::uint8_t>& keep) {
  CHECK_EQ(keep.size(), size());
  const std::size_t before = size();
  ForEachArray(*this, [&](auto& array) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (keep[i]) array[kept++] = array[i];
    }
    array.resize(kept);
  });
  return before - size();
}

}  // namespace surfit
