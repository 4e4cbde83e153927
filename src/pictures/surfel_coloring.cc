#include "pictures/surfel_coloring.h"

#include <algorithm>

namespace surfit {
namespace {

constexpr float kHeadlight = 0.35f;  // enough to see shapes, little enough to read the scale by

std::uint8_t UnitToByte(float component) {
  return static_cast<std::uint8_t>(std::clamp(127.5f * (1 + component) + 0.5f, 0.f, 255.f));
}

}  // namespace

SurfelColoring ColorByColor(const SurfelMap& map) {
  SurfelColoring coloring;
  coloring.title = "Colour";
  coloring.color_of = [&map](std::size_t i) { return map[i].color; };
  return coloring;
}

SurfelColoring ColorByNormal(const SurfelMap& map) {
  SurfelColoring coloring;
  coloring.title = "Normals";
  coloring.color_of = [&map](std::size_t i) {
    return Rgb8{UnitToByte(map.nx[i]), UnitToByte(map.ny[i]), UnitToByte(map.nz[i])};
  };
  coloring.legend = "(red, green, blue) = (1 + n) / 2 for the normal n in the world frame";
  return coloring;
}

SurfelColoring ColorByConfidence(const SurfelMap& map) {
  constexpr float kLeastLow = 1e-2f, kDecades = 1e4f;
  const auto [least, greatest] = std::minmax_element(map.confidence.begin(), map.confidence.end());
  const float high = std::max(*greatest, 1.f);
  const float low = std::max({std::min(*least, 1.f), kLeastLow, high / kDecades});
  SurfelColoring coloring;
  coloring.title = "Confidence";
  coloring.scale.emplace(low, high, /*logarithmic=*/true);
  coloring.color_of = [&map, scale = *coloring.scale](std::size_t i) {
    return scale.ColorOf(map.confidence[i]);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "sum of the observations' weights";
  return coloring;
}

SurfelColoring ColorByLastSeen(const SurfelMap& map) {
  const auto [first, last] = std::minmax_element(map.last_seen.begin(), map.last_seen.end());
  SurfelColoring coloring;
  coloring.title = "Last seen";
  coloring.scale.emplace(*first, *last, /*logarithmic=*/false);
  coloring.color_of = [&map, scale = *coloring.scale](std::size_t i) {
    return scale.ColorOf(map.last_seen[i]);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "frame";
  return coloring;
}

}  // namespace surfit
