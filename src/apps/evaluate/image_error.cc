#include "apps/evaluate/image_error.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace surfit {
namespace {

constexpr double kPeak = 255;
constexpr double kC1 = (0.01 * kPeak) * (0.01 * kPeak), kC2 = (0.03 * kPeak) * (0.03 * kPeak);

std::array<cv::Mat, 3> ChannelsOf(const Image<Rgb8>& image) {
  const cv::Mat bytes(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat floats;
  bytes.convertTo(floats, CV_32FC3);
  std::array<cv::Mat, 3> channels;
  cv::split(floats, channels.data());
  return channels;
}

// The sums are exact, because all terms are integers.
struct ChannelMoments {
  ChannelMoments(const Image<Rgb8>& image, const Image<Rgb8>& reference,
                 const PixelMask& compared) {
    CHECK_EQ(image.size(), reference.size());
    CHECK_EQ(image.size(), compared.size());
    for (std::size_t i = 0; i < image.size(); ++i) {
      if (compared[i] == 0) continue;
      const Eigen::Array3d x(image[i].r, image[i].g, image[i].b);
      const Eigen::Array3d y(reference[i].r, reference[i].g, reference[i].b);
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
  }

  Eigen::Array3d xx = Eigen::Array3d::Zero(), xy = xx, yy = xx;
};

double PsnrOf(double squares, std::size_t pixels) {
  if (pixels == 0) return 0;
  const double mse = squares / (3. * static_cast<double>(pixels));
  return mse > 0 ? std::min(kMaxPsnr_db, 10 * std::log10(kPeak * kPeak / mse)) : kMaxPsnr_db;
}

cv::Mat Smoothed(const cv::Mat& values) {
  cv::Mat smooth;
  cv::GaussianBlur(values, smooth, {11, 11}, 1.5, 1.5, cv::BORDER_REFLECT_101);
  return smooth;
}

cv::Mat SimilarityOf(const cv::Mat& x, const cv::Mat& y) {
  const cv::Mat mean_x = Smoothed(x), mean_y = Smoothed(y);
  const cv::Mat mean_xx = mean_x.mul(mean_x), mean_yy = mean_y.mul(mean_y),
                mean_xy = mean_x.mul(mean_y);
  const cv::Mat var_x = Smoothed(x.mul(x)) - mean_xx, var_y = Smoothed(y.mul(y)) - mean_yy,
                covariance = Smoothed(x.mul(y)) - mean_xy;
  const cv::Mat above = (2 * mean_xy + kC1).mul(2 * covariance + kC2);
  const cv::Mat below = (mean_xx + mean_yy + kC1).mul(var_x + var_y + kC2);
  return above / below;
}

}  // namespace

double Psnr(const Image<Rgb8>& image, const Image<Rgb8>& reference, const PixelMask& compared) {
  const ChannelMoments sums(image, reference, compared);
  return PsnrOf((sums.xx - 2 * sums.xy + sums.yy).sum(), CountOf(compared));
}

// x: image value. y: reference value. The best gain g reduces sum (g x - y)^2 to sum y^2 - (sum x
// y)^2 / sum x^2.
double PsnrByGain(const Image<Rgb8>& image, const Image<Rgb8>& reference,
                  const PixelMask& compared) {
  const ChannelMoments sums(image, reference, compared);
  const Eigen::Array3d explained = (sums.xx > 0).select(sums.xy.square() / sums.xx, 0);
  return PsnrOf((sums.yy - explained).sum(), CountOf(compared));
}

Image<float> StructuralSimilarity(const Image<Rgb8>& image, const Image<Rgb8>& reference) {
  CHECK(image.width() == reference.width() && image.height() == reference.height());
  const auto x = ChannelsOf(image), y = ChannelsOf(reference);
  Image<float> similarity(image.width(), image.height());
  cv::Mat mean(image.height(), image.width(), CV_32FC1, similarity.data());
  mean = 0;
  for (int i = 0; i < 3; ++i) mean += SimilarityOf(x[i], y[i]) / 3;
  return similarity;
}

double MeanOf(const Image<float>& values, const PixelMask& compared) {
  CHECK_EQ(values.size(), compared.size());
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += compared[i] != 0 ? values[i] : 0.;
  const std::size_t count = CountOf(compared);
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

std::size_t CountOf(const PixelMask& mask) {
  return static_cast<std::size_t>(
      std::count_if(mask.begin(), mask.end(), [](std::uint8_t is_in) { return is_in != 0; }));
}

}  // namespace surfit
