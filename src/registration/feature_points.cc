#include "registration/feature_points.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace surfit {
namespace {

constexpr int kMaxFeatures = 2000;
constexpr int kLayersPerOctave = 3;
constexpr double kMinContrast = 0.015;  // even rooms have little; Lowe's is 0.04
constexpr double kMaxEdgeRatio = 10;
constexpr double kBlurSigmaPx = 1.6;
constexpr int kDepthRadiusPx = 2;
constexpr double kPlaceSigmaPx = 1.5;  // of a feature in an image from elsewhere
constexpr float kMaxDistanceRatio = 0.95f;

// The square root of a histogram with sum 1, so that its Euclidean length is 1.
void WriteRootDescriptor(const cv::Mat& descriptor, float* out) {
  const auto* const in = descriptor.ptr<float>();
  float sum = 0;
  for (int i = 0; i < descriptor.cols; ++i) sum += in[i];
  for (int i = 0; i < descriptor.cols; ++i) out[i] = sum > 0 ? std::sqrt(in[i] / sum) : 0;
}

// A row's or a column's largest and second largest cosine.
struct Nearest {
  int index = -1;
  float cosine = -2;
  float second_cosine = -2;

  void Offer(int other, float value) {
    if (value > cosine) {
      second_cosine = std::exchange(cosine, value);
      index = other;
    } else {
      second_cosine = std::max(second_cosine, value);
    }
  }
  bool IsClear() const {
    const auto distance = [](float value) { return std::sqrt(std::max(0.f, 2 - 2 * value)); };
    return distance(cosine) < kMaxDistanceRatio * distance(second_cosine);
  }
};

// A view of the descriptors; OpenCV's own type has no const one.
cv::Mat Descriptors(const FeaturePoints& features) {
  return {features.descriptors.height(), features.descriptors.width(), CV_32F,
          const_cast<float*>(features.descriptors.data())};
}

}  // namespace

double DepthOfFeature(const Image<float>& depth_m, double u, double v) {
  const int column = static_cast<int>(std::lround(u)), row = static_cast<int>(std::lround(v));
  std::vector<float> valid;
  for (int y = std::max(0, row - kDepthRadiusPx);
       y <= std::min(depth_m.height() - 1, row + kDepthRadiusPx); ++y) {
    for (int x = std::max(0, column - kDepthRadiusPx);
         x <= std::min(depth_m.width() - 1, column + kDepthRadiusPx); ++x) {
      if (depth_m(x, y) > 0) valid.push_back(depth_m(x, y));
    }
  }
  if (valid.empty()) return 0;
  const auto middle = valid.begin() + static_cast<std::ptrdiff_t>(valid.size() / 2);
  std::nth_element(valid.begin(), middle, valid.end());
  return *middle;
}

double SigmaOfFeature(double depth_m, const DepthSensor& sensor, const ErrorModel& error_model) {
  return std::hypot(error_model.Sigma(depth_m, sensor.noise),
                    kPlaceSigmaPx * depth_m / sensor.camera.fx);
}

FeaturePoints FindFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                           const ErrorModel& error_model) {
  FeaturePoints features;
  if (color.empty()) return features;
  const cv::Mat rgb(color.height(), color.width(), CV_8UC3, const_cast<Rgb8*>(color.data()));
  cv::Mat gray, descriptors;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  const auto detector =
      cv::SIFT::create(kMaxFeatures, kLayersPerOctave, kMinContrast, kMaxEdgeRatio, kBlurSigmaPx);
  std::vector<cv::KeyPoint> keys;
  detector->detectAndCompute(gray, cv::noArray(), keys, descriptors);
  std::vector<int> kept;
  for (int i = 0; i < static_cast<int>(keys.size()); ++i) {
    const cv::Point2f place = keys[i].pt;
    const double depth_m = DepthOfFeature(surface.vertex.z, place.x, place.y);
    if (!(depth_m > 0)) continue;
    kept.push_back(i);
    features.points.emplace_back(surface.camera.Ray(place.x, place.y) * depth_m);
    features.sigmas_m.push_back(SigmaOfFeature(depth_m, surface.sensor(), error_model));
  }
  features.descriptors = Image<float>(descriptors.cols, static_cast<int>(kept.size()));
  for (int row = 0; row < features.size(); ++row) {
    WriteRootDescriptor(descriptors.row(kept[row]), features.descriptors.row(row));
  }
  return features;
}

std::vector<FeatureMatch> MatchFeatures(const FeaturePoints& source, const FeaturePoints& target) {
  std::vector<FeatureMatch> matches;
  if (source.size() == 0 || target.size() == 0) return matches;
  const cv::Mat cosines = Descriptors(source) * Descriptors(target).t();
  std::vector<Nearest> of_source(source.size()), of_target(target.size());
  for (int i = 0; i < source.size(); ++i) {
    for (int j = 0; j < target.size(); ++j) {
      of_source[i].Offer(j, cosines.at<float>(i, j));
      of_target[j].Offer(i, cosines.at<float>(i, j));
    }
  }
  for (int i = 0; i < source.size(); ++i) {
    const int j = of_source[i].index;
    if (of_target[j].index == i && of_source[i].IsClear()) matches.push_back({i, j});
  }
  return matches;
}

}  // namespace surfit
