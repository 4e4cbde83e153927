#include "registration/brightness.h"

#include <glog/logging.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace surfit {
namespace {

constexpr double kDetailSigmaPx = 3;

// ITU-R BT.601.
Image<float> Brightness(const Image<Rgb8>& color) {
  Image<float> brightness(color.width(), color.height());
  for (std::size_t i = 0; i < color.size(); ++i) {
    brightness[i] = (0.299f * color[i].r + 0.587f * color[i].g + 0.114f * color[i].b) / 255.f;
  }
  return brightness;
}

Image<float> HalfResolution(const Image<float>& fine) {
  Image<float> coarse(fine.width() / 2, fine.height() / 2);
  for (int v = 0; v < coarse.height(); ++v) {
    const float *above = fine.row(2 * v), *below = fine.row(2 * v + 1);
    for (int u = 0; u < coarse.width(); ++u, above += 2, below += 2) {
      coarse(u, v) = (above[0] + above[1] + below[0] + below[1]) / 4;
    }
  }
  return coarse;
}

Image<float> Detail(Image<float>& value) {
  Image<float> detail(value.width(), value.height());
  const cv::Mat in(value.height(), value.width(), CV_32F, value.data());
  cv::Mat out(value.height(), value.width(), CV_32F, detail.data());
  cv::GaussianBlur(in, out, cv::Size(), kDetailSigmaPx);
  cv::subtract(in, out, out);
  return detail;
}

}  // namespace

std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels) {
  CHECK(color.empty() || (color.width() == width && color.height() == height));
  Image<float> value = color.empty() ? Image<float>(width, height) : Brightness(color);
  std::vector<BrightnessLevel> pyramid;
  for (int level = 0; level < levels; ++level) {
    Image<float> next = level + 1 < levels ? HalfResolution(value) : Image<float>();
    Image<float> detail = Detail(value);
    pyramid.push_back({std::move(value), std::move(detail)});
    value = std::move(next);
  }
  return pyramid;
}

}  // namespace surfit
