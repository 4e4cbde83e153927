#include "places/match_features.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

namespace surfit {
namespace {

constexpr float kMaxHamming = 70;  // of 256
constexpr float kMaxRatio = 0.9f;

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
