#include "pictures/surfel_coloring.h"

#include <algorithm>
#include <limits>

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
  coloring.color_of = [&map](std::int32_t id) { return map.Color(id); };
  return coloring;
}

SurfelColoring ColorByNormal(const SurfelMap& map) {
  SurfelColoring coloring;
  coloring.title = "Normals";
  coloring.color_of = [&map](std::int32_t id) {
    const Eigen::Vector3f normal = map[id].normal_in_world;
    return Rgb8{UnitToByte(normal.x()), UnitToByte(normal.y()), UnitToByte(normal.z())};
  };
  coloring.legend = "(red, green, blue) = (1 + n) / 2 for the normal n in the world frame";
  return coloring;
}

SurfelColoring ColorByConfidence(const SurfelMap& map) {
  constexpr float kLeastLow = 1e-2f, kDecades = 1e4f;
  float least = 1, high = 1;
  for (const std::int32_t id : map.Ids()) {
    const float confidence = map[id].confidence;
    least = std::min(least, confidence);
    high = std::max(high, confidence);
  }
  const float low = std::max({least, kLeastLow, high / kDecades});
  SurfelColoring coloring;
  coloring.title = "Confidence";
  coloring.scale.emplace(low, high, /*logarithmic=*/true);
  coloring.color_of = [&map, scale = *coloring.scale](std::int32_t id) {
    return scale.ColorOf(map[id].confidence);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "sum of the observations' weights";
  return coloring;
}

SurfelColoring ColorByLastSeen(const SurfelMap& map) {
  std::int32_t first = std::numeric_limits<std::int32_t>::max();
  std::int32_t last = std::numeric_limits<std::int32_t>::min();
  for (const std::int32_t id : map.Ids()) {
    first = std::min(first, map[id].last_seen);
    last = std::max(last, map[id].last_seen);
  }
  SurfelColoring coloring;
  coloring.title = "Last seen";
  coloring.scale.emplace(first, last, /*logarithmic=*/false);
  coloring.color_of = [&map, scale = *coloring.scale](std::int32_t id) {
    return scale.ColorOf(map[id].last_seen);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "frame";
  return coloring;
}

}  // namespace surfit
