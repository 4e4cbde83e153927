#include "places/orb_features.h"

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "registration/feature_points.h"

namespace surfit {
namespace {

constexpr int kGridColumns = 8, kGridRows = 6;
constexpr int kDetectedPerKept = 4;  // before the strongest of each cell are chosen
constexpr float kScaleFactor = 1.2f;
constexpr int kScales = 8;
constexpr int kBorderPx = 15;     // the patch's half width: turned corners wrap into its border
constexpr int kFastContrast = 7;  // of 255: even rooms have little; OpenCV's is 20

cv::Ptr<cv::ORB> MakeOrb(int max_count) {
  constexpr int kFirstLevel = 0, kComparedPoints = 2, kPatchPx = 31;
  return cv::ORB::create(kDetectedPerKept * max_count, kScaleFactor, kScales, kBorderPx,
                         kFirstLevel, kComparedPoints, cv::ORB::HARRIS_SCORE, kPatchPx,
                         kFastContrast);
}

// The strongest of each cell, those of equal strength in the order found.
std::vector<cv::KeyPoint> Spread(std::vector<cv::KeyPoint> keys, const cv::Size& size,
                                 int max_count) {
  std::stable_sort(keys.begin(), keys.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    return a.response > b.response;
  });
  const int per_cell = std::max(1, max_count / (kGridColumns * kGridRows));
  std::vector<int> counts(kGridColumns * kGridRows, 0);
  std::vector<cv::KeyPoint> kept;
  for (const cv::KeyPoint& key : keys) {
    const int column = static_cast<int>(key.pt.x) * kGridColumns / size.width;
    const int row = static_cast<int>(key.pt.y) * kGridRows / size.height;
    if (counts[row * kGridColumns + column]++ < per_cell) kept.push_back(key);
    if (static_cast<int>(kept.size()) == max_count) break;
  }
  return kept;
}

}  // namespace

std::vector<PlaceFeature> FindOrbFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                                          int max_count) {
  std::vector<PlaceFeature> features;
  if (color.empty()) return features;
  const cv::Mat rgb(color.height(), color.width(), CV_8UC3, const_cast<Rgb8*>(color.data()));
  cv::Mat gray, descriptors;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  const cv::Ptr<cv::ORB> orb = MakeOrb(max_count);
  std::vector<cv::KeyPoint> keys;
  orb->detect(gray, keys);
  keys = Spread(std::move(keys), gray.size(), max_count);
  orb->compute(gray, keys, descriptors);
  for (int i = 0; i < static_cast<int>(keys.size()); ++i) {
    const cv::Point2f place = keys[i].pt;
    const double depth_m = DepthOfFeature(surface.vertex.z, place.x, place.y);
    if (!(depth_m > 0)) continue;
    PlaceFeature feature;
    feature.point = (surface.camera.Ray(place.x, place.y) * depth_m).cast<float>();
    std::memcpy(feature.descriptor.data(), descriptors.ptr(i), sizeof(feature.descriptor));
    features.push_back(feature);
  }
  return features;
}

}  // namespace surfit
