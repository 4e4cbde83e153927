#include "pictures/color_bar.h"

#include <cmath>

namespace surfit {

void DrawColorBar(PlotCanvas* canvas, const ColorScale& scale, const PixelBox& box) {
  canvas->UsePixels();
  canvas->SetLineWidth(2);
  for (double u = box.left; u <= box.right; ++u) {
    canvas->SetColor(scale.ColorAt((u - box.left) / (box.right - box.left)));
    canvas->Line({u, u}, {box.top, box.bottom});
  }
  const auto coordinate = [&](double value) {
    return scale.logarithmic() ? std::log10(value) : value;
  };
  AxisRange range = {coordinate(scale.low()), coordinate(scale.high())};
  if (range.end <= range.begin) range.end = range.begin + 1;
  canvas->SetLineWidth(1);
  canvas->DrawScale(box, range, scale.logarithmic());
}

}  // namespace surfit
