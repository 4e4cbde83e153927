#pragma once

#include "pictures/color_scale.h"
#include "pictures/plot_canvas.h"

namespace surfit {

// A bar of the scale's colours, low on the left, with numbers below it.
void DrawColorBar(PlotCanvas* canvas, const ColorScale& scale, const PixelBox& box);

}  // namespace surfit
