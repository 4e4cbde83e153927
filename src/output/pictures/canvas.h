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

// A place in an image, in pixels; the first pixel's centre is (0, 0).
struct PixelPoint {
  double u, v;
};

struct PixelBox {
  double left, top, right, bottom;
};

struct TextStyle {
  double height_px = 18;  // of a line of text
  double justify = 0;     // text begins at its point with 0, is centred with 0.5, ends with 1
  Rgb8 color = {20, 20, 20};
};

// The same pixels, for OpenCV.
cv::Mat AsMat(Image<Rgb8>* image);

// The pixels that a text takes, without margin.
double TextWidth(const std::string& text, const TextStyle& style);

// Lines, discs and text have smooth edges, boxes are whole pixels; what lies outside the image is
// left out. Text is ASCII, centred vertically at its point.
void DrawText(Image<Rgb8>* image, PixelPoint at, const std::string& text,
              const TextStyle& style = {});
void DrawLine(Image<Rgb8>* image, const std::vector<PixelPoint>& points, Rgb8 color,
              double width_px);
void DrawDisc(Image<Rgb8>* image, PixelPoint center, double radius_px, Rgb8 color);
void FillBox(Image<Rgb8>* image, const PixelBox& box, Rgb8 color);
// Draws an image into a box of another size by averaging.
void DrawImage(Image<Rgb8>* image, const cv::Rect& box, const Image<Rgb8>& source);

// Throws InputError naming the path where the file cannot be written.
void WritePng(const Image<Rgb8>& image, const std::string& path);

// Colours for numbers from low to high: viridis, dark blue through green to yellow, even to the
// eye.
class ColorScale {
 public:
  // Where logarithmic, 0 < low. Needs low <= high.
  ColorScale(double low, double high, bool logarithmic);

  double low() const { return low_; }
  double high() const { return high_; }
  bool logarithmic() const { return logarithmic_; }

  // 0 at low, 1 at high, clamped to them.
  double Position(double value) const;
  Rgb8 ColorAt(double position) const;
  Rgb8 ColorOf(double value) const { return ColorAt(Position(value)); }

 private:
  double low_, high_;
  bool logarithmic_;
  std::array<Rgb8, 256> colors_;
};

// A bar of the scale's colours, low on the left, with numbers below it.
void DrawColorBar(Image<Rgb8>* image, const ColorScale& scale, const PixelBox& box);

// The image that the function gives for each pixel and its index, computed in parallel.
Image<Rgb8> ColorIndices(const Image<std::int32_t>& indices,
                         const std::function<Rgb8(int u, int v, std::int32_t index)>& color_of);

// The colour at this share of its brightness, 0 <= brightness <= 1.
Rgb8 Dimmed(Rgb8 color, float brightness);

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
