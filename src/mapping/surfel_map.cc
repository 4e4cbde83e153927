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
  f(m.radius_m), f(m.confidence), f(m.first_seen), f(m.last_seen), f(m.at_edge);
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
  s.color = Color(i);
  s.radius_m = radius_m[i];
  s.confidence = confidence[i];
  s.first_seen = first_seen[i];
  s.last_seen = last_seen[i];
  s.at_edge = at_edge[i] != 0;
  return s;
}

Rgb8 SurfelMap::Color(std::size_t i) const {
  return {ToByte(red[i]), ToByte(green[i]), ToByte(blue[i])};
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
  at_edge[i] = s.at_edge;
}

void SurfelMap::Merge(std::size_t i, const SurfelObservation& seen, bool refine,
                      float max_confidence) {
  // (w q + a p) / (w + a) = q + share (p - q)
  const float share = seen.weight / (confidence[i] + seen.weight);
  if (refine) {
    x[i] += share * (seen.position_in_world.x() - x[i]);
    y[i] += share * (seen.position_in_world.y() - y[i]);
    z[i] += share * (seen.position_in_world.z() - z[i]);
    Eigen::Vector3f n(nx[i], ny[i], nz[i]);
    n = (n + share * (seen.normal_in_world - n)).normalized();
    nx[i] = n.x();
    ny[i] = n.y();
    nz[i] = n.z();
    radius_m[i] = std::min(radius_m[i], seen.radius_m);
  }
  const auto mix = [share](std::uint16_t* old, std::uint8_t byte) {
    const float value = static_cast<float>(*old);
    *old = static_cast<std::uint16_t>(value + share * (static_cast<float>(FromByte(byte)) - value) +
                                      0.5f);
  };
  mix(&red[i], seen.color.r);
  mix(&green[i], seen.color.g);
  mix(&blue[i], seen.color.b);
  if (!seen.at_edge) at_edge[i] = 0;
  confidence[i] = std::min(confidence[i] + seen.weight, max_confidence);
}

std::size_t SurfelMap::Replace(const std::vector<std::uint8_t>& remove,
                               const std::vector<Surfel>& added) {
  CHECK_EQ(remove.size(), size());
  std::vector<std::size_t> holes;
  for (std::size_t i = 0; i < remove.size(); ++i) {
    if (remove[i]) holes.push_back(i);
  }
  const std::size_t reused = std::min(holes.size(), added.size());
  for (std::size_t k = 0; k < reused; ++k) Set(holes[k], added[k]);
  for (std::size_t k = reused; k < added.size(); ++k) Append(added[k]);
  FillFromTheEnd({holes.begin() + reused, holes.end()});
  return holes.size();
}

void SurfelMap::FillFromTheEnd(const std::vector<std::size_t>& holes) {
  std::size_t last_hole = holes.size();
  std::size_t end = size();
  for (std::size_t k = 0; k < last_hole; ++k) {
    // Holes at the very end go without being filled.
    while (last_hole > k && holes[last_hole - 1] == end - 1) {
      --last_hole;
      --end;
    }
    if (k >= last_hole) break;
    --end;
    ForEachArray(*this, [&](auto& array) { array[holes[k]] = array[end]; });
  }
  ForEachArray(*this, [&](auto& array) { array.resize(end); });
}

}  // namespace surfit
