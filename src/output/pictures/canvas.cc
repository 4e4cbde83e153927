#include "output/pictures/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "io/images/image_files.h"
#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

static_assert(sizeof(Rgb8) == 3, "images are shared with OpenCV");

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr int kFiner = 4;        // text is drawn this much larger, then averaged
constexpr int kShift = 4;        // fractional bits of OpenCV's coordinates
constexpr double kCapital = 21;  // height of the font's capitals at scale 1

cv::Scalar AsScalar(Rgb8 color) { return {1. * color.r, 1. * color.g, 1. * color.b}; }

cv::Point Fixed(PixelPoint p) {
  return {cvRound(p.u * (1 << kShift)), cvRound(p.v * (1 << kShift))};
}

// The strokes of a text in the finer pixels.
struct Strokes {
  double scale, capital;
  int thickness;
  cv::Size size;

  Strokes(const std::string& text, double height_px)
      : scale(kFiner * 0.7 * height_px / kCapital),
        capital(scale * kCapital),
        thickness(std::max(1, cvRound(kFiner * height_px / 13))) {
    int below = 0;
    size = cv::getTextSize(text, kFont, scale, thickness, &below);
  }
};

}  // namespace

cv::Mat AsMat(Image<Rgb8>* image) {
  return {image->height(), image->width(), CV_8UC3, image->data()};
}

double TextWidth(const std::string& text, const TextStyle& style) {
  return static_cast<double>(Strokes(text, style.height_px).size.width) / kFiner;
}

void DrawText(Image<Rgb8>* image, PixelPoint at, const std::string& text, const TextStyle& style) {
  const Strokes strokes(text, style.height_px);
  const double begin = at.u - style.justify * strokes.size.width / kFiner;
  const cv::Rect whole(0, 0, image->width(), image->height());
  const cv::Rect box =
      whole & cv::Rect(cvFloor(begin), cvFloor(at.v - style.height_px),
                       strokes.size.width / kFiner + 3, cvCeil(2 * style.height_px) + 1);
  if (box.empty()) return;
  cv::Mat place = AsMat(image)(box), finer;
  cv::resize(place, finer, box.size() * kFiner, 0, 0, cv::INTER_NEAREST);
  const cv::Point origin(cvRound(kFiner * (begin - box.x)),
                         cvRound(kFiner * (at.v + 0.5 - box.y) + strokes.capital / 2));
  cv::putText(finer, text, origin, kFont, strokes.scale, AsScalar(style.color), strokes.thickness,
              cv::LINE_AA);
  cv::resize(finer, place, box.size(), 0, 0, cv::INTER_AREA);
}

void DrawImage(Image<Rgb8>* image, const cv::Rect& box, const Image<Rgb8>& source) {
  const cv::Mat mat(source.height(), source.width(), CV_8UC3, const_cast<Rgb8*>(source.data()));
  cv::resize(mat, AsMat(image)(box), box.size(), 0, 0, cv::INTER_AREA);
}

void DrawLine(Image<Rgb8>* image, const std::vector<PixelPoint>& points, Rgb8 color,
              double width_px) {
  std::vector<cv::Point> line;
  line.reserve(points.size());
  for (const PixelPoint& point : points) line.push_back(Fixed(point));
  const int thickness = std::max(1, cvRound(width_px) - 1);  // the smooth edge takes a pixel more
  cv::polylines(AsMat(image), line, false, AsScalar(color), thickness, cv::LINE_AA, kShift);
}

void DrawDisc(Image<Rgb8>* image, PixelPoint center, double radius_px, Rgb8 color) {
  cv::circle(AsMat(image), Fixed(center), cvRound(radius_px * (1 << kShift)), AsScalar(color),
             cv::FILLED, cv::LINE_AA, kShift);
}

void FillBox(Image<Rgb8>* image, const PixelBox& box, Rgb8 color) {
  cv::rectangle(AsMat(image), cv::Point(cvRound(box.left), cvRound(box.top)),
                cv::Point(cvRound(box.right), cvRound(box.bottom)), AsScalar(color), cv::FILLED);
}

void WritePng(const Image<Rgb8>& image, const std::string& path) {
  const std::string bytes = EncodePng(image);
  WriteFileAtomically(path, [&](std::ostream& file) { file << bytes; });
}

}  // namespace surfit
