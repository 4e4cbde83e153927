#include "pictures/color_scale.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace surfit {

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

}  // namespace surfit
