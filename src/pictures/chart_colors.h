#pragma once

#include <array>
#include <cstddef>

#include "surfit/core/image.h"

namespace surfit {

inline constexpr Rgb8 kChartPaper = {255, 255, 255}, kChartInk = {20, 20, 20};

// Colours that tell series apart, again from the first where these are more.
inline Rgb8 SeriesColor(std::size_t i) {
  constexpr std::array<Rgb8, 9> kColors = {{{20, 90, 210},
                                            {230, 90, 0},
                                            {20, 150, 60},
                                            {200, 30, 130},
                                            {0, 160, 190},
                                            {130, 90, 40},
                                            {110, 60, 190},
                                            {220, 170, 0},
                                            {120, 120, 120}}};
  return kColors[i % kColors.size()];
}

}  // namespace surfit
