#pragma once

#include <functional>
#include <optional>
#include <string>

#include "pictures/color_scale.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// One way of colouring the surfels of a map, with what a reader must know to read the colours.
// Refers to the map: it must outlive the colouring.
struct SurfelColoring {
  std::string title;
  std::function<Rgb8(std::int32_t)> color_of;  // of the surfel with this id
  // The share of the colour that is lit from the camera: 0 = the same brightness everywhere.
  float headlight = 0;
  std::string legend;               // in words
  std::optional<ColorScale> scale;  // as a bar of colours
};

// The surfels' own colours.
SurfelColoring ColorByColor(const SurfelMap& map);
// (1 + n) / 2 of the normal in the world: x red, y green, z blue.
SurfelColoring ColorByNormal(const SurfelMap& map);
// From min(1, least) to the greatest confidence, logarithmic, but at most four decades.
SurfelColoring ColorByConfidence(const SurfelMap& map);
// From the first to the last frame in which any surfel was last seen.
SurfelColoring ColorByLastSeen(const SurfelMap& map);

}  // namespace surfit
