#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "surfit/core/image.h"

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

}  // namespace surfit
