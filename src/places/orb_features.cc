#include "places/orb_features.h"

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace surfit {
namespace {

constexpr int kGridColumns = 8, kGridRows = 6;
constexpr int kDetectedPerKept = 4;  // before the strongest of each cell are chosen
constexpr float kScaleFactor = 1.2f;
constexpr int kScales = 8;
constexpr int kBorderPx = 15;     // the patch's half width: turned corners wrap into its border
constexpr int kFastContrast = 7;  // of 255: even rooms have little; OpenCV's is 20

constexpr float kMaxHamming = 70;  // of 256
constexpr float kMaxRatio = 0.9f;

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

// Descriptors in rows. Copies: OpenCV's matrices have one step between rows of bytes.
cv::Mat Rows(const std::vector<PlaceFeature>& features) {
  constexpr int kBytes = sizeof(BinaryDescriptor);
  cv::Mat rows(static_cast<int>(features.size()), kBytes, CV_8U);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const auto* const bytes = reinterpret_cast<const uchar*>(features[i].descriptor.data());
    std::copy(bytes, bytes + kBytes, rows.ptr(static_cast<int>(i)));
  }
  return rows;
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

std::vector<FeatureMatch> MatchFeatures(const std::vector<PlaceFeature>& source,
                                        const std::vector<PlaceFeature>& target) {
  std::vector<FeatureMatch> matches;
  if (source.empty() || target.size() < 2) return matches;
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  const cv::Mat source_rows = Rows(source), target_rows = Rows(target);
  std::vector<std::vector<cv::DMatch>> forwards;
  std::vector<cv::DMatch> backwards;
  matcher.knnMatch(source_rows, target_rows, forwards, 2);
  matcher.match(target_rows, source_rows, backwards);
  for (const std::vector<cv::DMatch>& nearest : forwards) {
    const cv::DMatch& best = nearest[0];
    if (best.distance > kMaxHamming || best.distance >= kMaxRatio * nearest[1].distance) continue;
    if (backwards[best.trainIdx].trainIdx == best.queryIdx) {
      matches.push_back({best.queryIdx, best.trainIdx});
    }
  }
  return matches;
}

}  // namespace surfit
