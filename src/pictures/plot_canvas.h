#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "pictures/equal_aspect.h"
#include "surfit/core/image.h"

namespace surfit {

// A rectangle of an image, in pixels.
struct PixelBox {
  double left, top, right, bottom;
};

struct Axes {
  PixelBox box;
  AxisRanges ranges;
  std::string title, x_label, y_label;
  // Whether the y range holds common logarithms; its numbers are powers of ten then.
  bool y_logarithmic = false;
};

// Draws lines, text and axes upon an image, through PLplot and Cairo in memory. The image holds the
// drawing once the canvas is gone. Coordinates are pixels, the first pixel's centre being (0, 0),
// until BeginAxes. PLplot knows one drawing at a time: a second canvas waits for the first to go.
class PlotCanvas {
 public:
  enum class MarkerShape { kCircle, kSquare };

  explicit PlotCanvas(Image<Rgb8>* image);
  ~PlotCanvas();
  PlotCanvas(const PlotCanvas&) = delete;
  PlotCanvas& operator=(const PlotCanvas&) = delete;

  void SetColor(Rgb8 color);
  void SetLineWidth(double width_px);
  void SetTextHeight(double height_px);

  // Coordinates are pixels again.
  void UsePixels();
  // Draws a frame with ticks, numbers, grid and labels; coordinates are then those of the axes, and
  // what lies outside them is clipped.
  void BeginAxes(const Axes& axes);
  // Frames the box and numbers its lower edge; where `logarithmic`, range holds common logarithms
  // and the numbers are powers of ten. Leaves coordinates in pixels.
  void DrawScale(const PixelBox& box, AxisRange range, bool logarithmic);

  // Centred vertically at y; begins at x with justify 0, is centred with 0.5, ends with 1.
  void Text(double x, double y, const std::string& text, double justify = 0);
  void Line(const std::vector<double>& x, const std::vector<double>& y);
  // A filled shape centred at (x, y).
  void Marker(double x, double y, MarkerShape shape);

 private:
  void SetBox(const PixelBox& box, const AxisRanges& ranges);

  std::lock_guard<std::mutex> lock_;
  int stream_ = 0;
  int width_px_;
  int height_px_;
};

}  // namespace surfit
