#include "registration/icp/view_level.h"

#include <glog/logging.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace surfit {
namespace {

constexpr double kDetailSigmaPx = 3;

Image<float> Brightness(const Image<Rgb8>& color) {
  Image<float> brightness(color.width(), color.height());
  for (std::size_t i = 0; i < color.size(); ++i) brightness[i] = GreyOf(color[i]);
  return brightness;
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

BrightnessLevel BrightnessOf(Image<float> value) {
  Image<float> detail = Detail(value);
  return {std::move(value), std::move(detail)};
}

std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels) {
  CHECK(color.empty() || (color.width() == width && color.height() == height));
  Image<float> value = color.empty() ? Image<float>(width, height) : Brightness(color);
  std::vector<BrightnessLevel> pyramid;
  for (int level = 0; level < levels; ++level) {
    Image<float> next = level + 1 < levels ? HalfResolution(value) : Image<float>();
    pyramid.push_back(BrightnessOf(std::move(value)));
    value = std::move(next);
  }
  return pyramid;
}

BrightnessLevel CoarseBrightness(const Image<Rgb8>& color, int halvings) {
  if (color.empty()) return {};
  Image<float> value = Brightness(color);
  for (int i = 0; i < halvings; ++i) value = HalfResolution(value);
  return {std::move(value), {}};
}

}  // namespace surfit
