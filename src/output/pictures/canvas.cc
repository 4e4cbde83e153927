#include "output/pictures/canvas.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "io/images/image_files.h"
#include "output/pictures/axes.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

static_assert(sizeof(Rgb8) == 3, "images are shared with OpenCV");

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr int kFiner = 4;  // supersampling factor of text
constexpr int kShift = 4;
constexpr double kCapital = 21;

cv::Scalar AsScalar(Rgb8 color) { return {1. * color.r, 1. * color.g, 1. * color.b}; }

cv::Point Fixed(PixelPoint p) {
  return {cvRound(p.u * (1 << kShift)), cvRound(p.v * (1 << kShift))};
}

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

constexpr float kHeadlight = 0.35f;  // shading, with the colour scale still readable

std::uint8_t UnitToByte(float component) {
  return static_cast<std::uint8_t>(std::clamp(127.5f * (1 + component) + 0.5f, 0.f, 255.f));
}

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
  const int thickness = std::max(1, cvRound(width_px) - 1);  // antialiasing adds one pixel
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

ColorScale::ColorScale(double low, double high, bool logarithmic)
    : low_(low), high_(high), logarithmic_(logarithmic) {
  CHECK_LE(low, high);
  CHECK(!logarithmic || low > 0);
  cv::Mat steps(1, 256, CV_8UC1), bgr;
  for (int i = 0; i < 256; ++i) steps.at<unsigned char>(i) = i;
  cv::applyColorMap(steps, bgr, cv::COLORMAP_VIRIDIS);
  for (int i = 0; i < 256; ++i) {
    const auto& color = bgr.at<cv::Vec3b>(i);
    colors_[i] = {color[2], color[1], color[0]};
  }
}

double ColorScale::Position(double value) const {
  if (!(value > low_) || high_ == low_) return 0;
  if (value >= high_) return 1;
  if (logarithmic_) return std::log(value / low_) / std::log(high_ / low_);
  return (value - low_) / (high_ - low_);
}

Rgb8 ColorScale::ColorAt(double position) const {
  return colors_[std::lround(std::clamp(position, 0., 1.) * 255)];
}

void DrawColorBar(Image<Rgb8>* image, const ColorScale& scale, const PixelBox& box) {
  constexpr int kTicks = 8;
  const double width = box.right - box.left;
  for (int column = 0; column <= width; ++column) {
    const double u = box.left + column;
    FillBox(image, {u, box.top, u, box.bottom}, scale.ColorAt(column / width));
  }
  const std::vector<double> ticks = scale.logarithmic()
                                        ? LogarithmicTicks(scale.low(), scale.high())
                                        : RoundTicks({scale.low(), scale.high()}, kTicks);
  for (const double tick : ticks) {
    const double u = box.left + width * scale.Position(tick);
    DrawLine(image, {{u, box.bottom}, {u, box.bottom + 5}}, kAxisInk, 1);
    DrawText(image, {u, box.bottom + 16}, TickText(tick), {15, 0.5, kAxisInk});
  }
}

Image<Rgb8> ColorIndices(const Image<std::int32_t>& indices,
                         const std::function<Rgb8(int, int, std::int32_t)>& color_of) {
  Image<Rgb8> colors(indices.width(), indices.height());
  ParallelFor(0, indices.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < indices.width(); ++u) colors(u, v) = color_of(u, v, indices(u, v));
    }
  });
  return colors;
}

Rgb8 Dimmed(Rgb8 color, float brightness) {
  const auto dim = [brightness](std::uint8_t component) {
    return static_cast<std::uint8_t>(std::lrint(component * brightness));
  };
  return {dim(color.r), dim(color.g), dim(color.b)};
}

SurfelColoring ColorByColor(const SurfelMap& map) {
  SurfelColoring coloring;
  coloring.title = "Colour";
  coloring.color_of = [&map](std::int32_t id) { return map.Color(id); };
  return coloring;
}

SurfelColoring ColorByNormal(const SurfelMap& map) {
  SurfelColoring coloring;
  coloring.title = "Normals";
  coloring.color_of = [&map](std::int32_t id) {
    const Eigen::Vector3f normal = map[id].normal_in_world;
    return Rgb8{UnitToByte(normal.x()), UnitToByte(normal.y()), UnitToByte(normal.z())};
  };
  coloring.legend = "(red, green, blue) = (1 + n) / 2 with the normal n in the world frame";
  return coloring;
}

SurfelColoring ColorByConfidence(const SurfelMap& map) {
  constexpr float kMinLow = 1e-2f, kDecades = 1e4f;
  float least = 1, high = 1;
  for (const std::int32_t id : map.Ids()) {
    const float confidence = map[id].confidence;
    least = std::min(least, confidence);
    high = std::max(high, confidence);
  }
  const float low = std::max({least, kMinLow, high / kDecades});
  SurfelColoring coloring;
  coloring.title = "Confidence";
  coloring.scale.emplace(low, high, /*logarithmic=*/true);
  coloring.color_of = [&map, scale = *coloring.scale](std::int32_t id) {
    return scale.ColorOf(map[id].confidence);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "sum of observation weights";
  return coloring;
}

SurfelColoring ColorByLastSeen(const SurfelMap& map) {
  std::int32_t first = std::numeric_limits<std::int32_t>::max();
  std::int32_t last = std::numeric_limits<std::int32_t>::min();
  for (const std::int32_t id : map.Ids()) {
    first = std::min(first, map[id].last_seen);
    last = std::max(last, map[id].last_seen);
  }
  SurfelColoring coloring;
  coloring.title = "Last seen";
  coloring.scale.emplace(first, last, /*logarithmic=*/false);
  coloring.color_of = [&map, scale = *coloring.scale](std::int32_t id) {
    return scale.ColorOf(map[id].last_seen);
  };
  coloring.headlight = kHeadlight;
  coloring.legend = "frame";
  return coloring;
}

}  // namespace surfit
