#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Point in an image, px; the centre of the first pixel is (0, 0).
struct PixelPoint {
  double u, v;
};

// Edges of a rectangle, px.
struct PixelBox {
  double left, top, right, bottom;
};

struct TextStyle {
  double height_px = 18;  // line height
  double justify = 0;  // alignment; 0: text starts at the point, 0.5: centred, 1: ends at the point
  Rgb8 color = {20, 20, 20};
};

// OpenCV header of the image. Shares the pixels in RGB order, so the image must outlive it.
cv::Mat AsMat(Image<Rgb8>* image);

// Width in px.
double TextWidth(const std::string& text, const TextStyle& style);

// Drawing functions, clipped to the image, except DrawImage(). Lines, discs and text are
// antialiased. Text must be ASCII and is centred vertically at its point.
void DrawText(Image<Rgb8>* image, PixelPoint at, const std::string& text,
              const TextStyle& style = {});
// Draws a polyline, at least 1 px wide.
void DrawLine(Image<Rgb8>* image, const std::vector<PixelPoint>& points, Rgb8 color,
              double width_px);
void DrawDisc(Image<Rgb8>* image, PixelPoint center, double radius_px, Rgb8 color);
// Includes the pixels at all four edges.
void FillBox(Image<Rgb8>* image, const PixelBox& box, Rgb8 color);
// Resizes an image to the box by area averaging. Throws cv::Exception if the box is not inside the
// image or the source is empty.
void DrawImage(Image<Rgb8>* image, const cv::Rect& box, const Image<Rgb8>& source);

// Throws InputError with the path if writing fails, and for an empty image.
void WritePng(const Image<Rgb8>& image, const std::string& path);

// Viridis colour map for values from low to high: dark blue, green, yellow.
class ColorScale {
 public:
  // Aborts unless low <= high, and 0 < low if logarithmic.
  ColorScale(double low, double high, bool logarithmic);

  double low() const { return low_; }
  double high() const { return high_; }
  bool logarithmic() const { return logarithmic_; }

  // Position of a value on the scale, clamped to [0, 1]. 0 for NaN, and for all values if low =
  // high.
  double Position(double value) const;
  // Colour of a position, which is clamped to [0, 1].
  Rgb8 ColorAt(double position) const;
  Rgb8 ColorOf(double value) const { return ColorAt(Position(value)); }

 private:
  double low_, high_;
  bool logarithmic_;
  std::array<Rgb8, 256> colors_;
};

// Draws a colour bar with ticks below it. The ticks need about 25 px below the box.
void DrawColorBar(Image<Rgb8>* image, const ColorScale& scale, const PixelBox& box);

// Colours each pixel by its index. Calls `color_of` in parallel. `color_of` must be thread-safe.
Image<Rgb8> ColorIndices(const Image<std::int32_t>& indices,
                         const std::function<Rgb8(int u, int v, std::int32_t index)>& color_of);

// Colour times a brightness from 0 to 1.
Rgb8 Dimmed(Rgb8 color, float brightness);

// Colouring of the surfels of a map, with a legend. The map must outlive this object.
struct SurfelColoring {
  std::string title;
  std::function<Rgb8(std::int32_t)> color_of;  // colour of a surfel id; thread-safe
  // Share of the brightness that depends on the angle between normal and viewing ray. 0: no
  // shading.
  float headlight = 0;
  std::string legend;               // may be empty
  std::optional<ColorScale> scale;  // std::nullopt: colours are no values
};

// Surfel colours.
SurfelColoring ColorByColor(const SurfelMap& map);
// Colours (1 + n) / 2 of the normal n in the world frame: x red, y green, z blue.
SurfelColoring ColorByNormal(const SurfelMap& map);
// Logarithmic scale up to the largest confidence, but at least to 1. It begins at the smallest
// confidence, at least 0.01, and has at most four decades.
SurfelColoring ColorByConfidence(const SurfelMap& map);
// Linear scale over the frame indices. Aborts for an empty map.
SurfelColoring ColorByLastSeen(const SurfelMap& map);

}  // namespace surfit
