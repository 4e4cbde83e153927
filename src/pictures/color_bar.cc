#include "pictures/color_bar.h"

#include <cmath>

namespace surfit {

void DrawColorBar(PlotCanvas* canvas, const ColorScale& scale, const PixelBox& box) {
  canvas->UsePixels();
  canvas->SetLineWidth(2);
  const int width = static_cast<int>(box.right - box.left);
  for (int column = 0; column <= width; ++column) {
    const double u = box.left + column;
    canvas->SetColor(scale.ColorAt(static_cast<double>(column) / width));
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
