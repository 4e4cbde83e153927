#include "registration/global/feature_points.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/median.h"
#include "registration/global/view_fit.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kGridColumns = 8, kGridRows = 6;
constexpr int kDetectedPerKept = 4;  // detected features per selected feature
constexpr float kScaleFactor = 1.2f;
constexpr int kScales = 8;
constexpr int kBorderPx = 15;  // minimum distance of features to the border; about half a patch
// FAST threshold in grey values (0 to 255). The OpenCV default, 20, is too high for rooms with
// little contrast.
constexpr int kFastContrast = 7;

constexpr int kDepthRadiusPx = 2;

constexpr int kMaxHamming = 70;  // maximum number of different bits of two descriptors, of 256
constexpr double kMaxRatio = 0.9;

cv::Ptr<cv::ORB> MakeOrb(int max_count) {
  constexpr int kFirstLevel = 0, kComparedPoints = 2, kPatchPx = 31;
  return cv::ORB::create(kDetectedPerKept * max_count, kScaleFactor, kScales, kBorderPx,
                         kFirstLevel, kComparedPoints, cv::ORB::HARRIS_SCORE, kPatchPx,
                         kFastContrast);
}

// Keeps the strongest keypoints of each grid cell. If responses are equal, the keypoint that was
// detected first is kept.
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

struct Nearest {
  static constexpr int kFarthest = 257;
  int index = -1;
  int distance = kFarthest, second_distance = kFarthest;

  void Offer(int other, int other_distance) {
    if (other_distance < distance) {
      second_distance = std::exchange(distance, other_distance);
      index = other;
    } else {
      second_distance = std::min(second_distance, other_distance);
    }
  }
  bool IsClear() const { return distance <= kMaxHamming && distance < kMaxRatio * second_distance; }
};

constexpr int kLevels = 3;
constexpr double kQuality = 0.01;  // minimum corner score, relative to the strongest corner
constexpr double kApart_px = 6;

constexpr int kRadius_px = 4, kSide_px = 2 * kRadius_px + 1;
constexpr int kSteps = 15;
constexpr float kSmallStep_px = 0.02f, kFarthest_px = 12;
// Minimum correlation with the previous image and with the first image.
constexpr float kMinCorrelationNext = 0.6f, kMinCorrelationFirst = 0.5f;
constexpr float kMinContrast = 0.008f;
constexpr int kTracksPerBlock = 16;

using Patch = Eigen::Array<float, kSide_px, kSide_px, Eigen::RowMajor>;

bool IsWithin(const Image<float>& image, const Eigen::Vector2f& at) {
  constexpr float kMargin = kRadius_px + 2;
  return at.x() >= kMargin && at.y() >= kMargin &&
         at.x() < static_cast<float>(image.width()) - kMargin &&
         at.y() < static_cast<float>(image.height()) - kMargin;
}

// Bilinearly interpolated patch around `at`, shifted by (beside_u, beside_v) px. IsWithin(image,
// at) must be true.
Patch PatchAt(const Image<float>& image, const Eigen::Vector2f& at, int beside_u = 0,
              int beside_v = 0) {
  const int left = static_cast<int>(at.x()), top = static_cast<int>(at.y());
  const float a = at.x() - static_cast<float>(left), b = at.y() - static_cast<float>(top);
  const auto from = [&](int u, int v) {
    const float* begin =
        image.row(top - kRadius_px + beside_v + v) + left - kRadius_px + beside_u + u;
    return Eigen::Map<const Patch, 0, Eigen::OuterStride<>>(begin,
                                                            Eigen::OuterStride<>(image.width()));
  };
  return (1 - b) * ((1 - a) * from(0, 0) + a * from(1, 0)) +
         b * ((1 - a) * from(0, 1) + a * from(1, 1));
}

float LengthOf(const Patch& patch) { return patch.matrix().norm(); }

// Patch with zero mean and unit norm, which is invariant to brightness gain and offset. Returns
// std::nullopt near the image border and for low contrast.
std::optional<Patch> NormalizedPatch(const Image<float>& image, const Eigen::Vector2f& at) {
  if (!IsWithin(image, at)) return std::nullopt;
  Patch patch = PatchAt(image, at);
  patch -= patch.mean();
  const float length = LengthOf(patch);
  if (!(length > kMinContrast * kSide_px)) return std::nullopt;
  return patch / length;
}

struct Found {
  Eigen::Vector2f at;
  float alike;  // correlation of both patches, at most 1
};

// Finds the source patch around `from` in the target. The search starts at `at`. Returns
// std::nullopt if the search fails.
std::optional<Found> FindPatch(const Image<float>& source, const Eigen::Vector2f& from,
                               const Image<float>& target, Eigen::Vector2f at) {
  const std::optional<Patch> wanted = NormalizedPatch(source, from);
  if (!wanted) return std::nullopt;
  const Patch values = PatchAt(source, from);
  const float length = 2 * LengthOf(values - values.mean());
  Patch by_u = (PatchAt(source, from, 1, 0) - PatchAt(source, from, -1, 0)) / length;
  Patch by_v = (PatchAt(source, from, 0, 1) - PatchAt(source, from, 0, -1)) / length;
  by_u -= by_u.mean();
  by_v -= by_v.mean();
  Eigen::Matrix2f hessian;
  hessian << (by_u * by_u).sum(), (by_u * by_v).sum(), (by_u * by_v).sum(), (by_v * by_v).sum();
  const Eigen::LDLT<Eigen::Matrix2f> factors(hessian);
  const Eigen::Vector2f begin = at;
  float step_px = kFarthest_px;
  for (int i = 0; i <= kSteps && step_px >= kSmallStep_px; ++i) {
    const std::optional<Patch> here = NormalizedPatch(target, at);
    if (!here) return std::nullopt;
    const Patch difference = *here - *wanted;
    const Eigen::Vector2f step =
        factors.solve(Eigen::Vector2f((by_u * difference).sum(), (by_v * difference).sum()));
    at -= step;
    step_px = step.norm();
    if (!((at - begin).norm() < kFarthest_px)) return std::nullopt;
  }
  const std::optional<Patch> here = NormalizedPatch(target, at);
  if (!here) return std::nullopt;
  return Found{at, (*here * *wanted).sum()};
}

// Conversion of pixel coordinates to the next coarser and the next finer pyramid level.
Eigen::Vector2f Coarser(const Eigen::Vector2f& at) { return (at.array() - 0.5f) / 2; }
Eigen::Vector2f Finer(const Eigen::Vector2f& at) { return at.array() * 2 + 0.5f; }

// Finds a source corner in the target image, from coarse to fine pyramid levels. `expected`:
// initial position in the target.
std::optional<Eigen::Vector2f> FindCorner(const GreyPyramid& source, const Eigen::Vector2f& from,
                                          const GreyPyramid& target,
                                          const Eigen::Vector2f& expected) {
  std::array<Eigen::Vector2f, kLevels> from_at;
  from_at[0] = from;
  Eigen::Vector2f at = expected;
  for (int level = 1; level < kLevels; ++level) {
    from_at[level] = Coarser(from_at[level - 1]);
    at = Coarser(at);
  }
  for (int level = kLevels - 1; level > 0; --level) {
    const auto found = FindPatch(source[level], from_at[level], target[level], at);
    at = Finer(found && found->alike > kMinCorrelationNext ? found->at : at);
  }
  const auto found = FindPatch(source[0], from, target[0], at);
  if (!found || !(found->alike > kMinCorrelationNext)) return std::nullopt;
  return found->at;
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
  return MedianOf(std::move(valid));
}

double SigmaOfFeature(double depth_m, double place_sigma_px, const DepthSensor& sensor,
                      const ErrorModel& error_model) {
  return std::hypot(error_model.Sigma(depth_m, sensor.noise),
                    place_sigma_px * depth_m / sensor.camera.fx);
}

FeaturePoints FindFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                           const ErrorModel& error_model, int max_count) {
  FeaturePoints features;
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
    features.points.emplace_back(surface.camera.Ray(place.x, place.y) * depth_m);
    features.sigmas_m.push_back(
        SigmaOfFeature(depth_m, kFeaturePlaceSigmaPx, surface.sensor(), error_model));
    BinaryDescriptor& descriptor = features.descriptors.emplace_back();
    std::memcpy(descriptor.data(), descriptors.ptr(i), sizeof(descriptor));
  }
  return features;
}

std::vector<FeatureMatch> MatchFeatures(const FeaturePoints& source, const FeaturePoints& target) {
  std::vector<Nearest> of_source(source.size()), of_target(target.size());
  WithInstructions([&](auto /*instructions*/) {
    for (int i = 0; i < source.size(); ++i) {
      for (int j = 0; j < target.size(); ++j) {
        const int distance = Hamming(source.descriptors[i], target.descriptors[j]);
        of_source[i].Offer(j, distance);
        of_target[j].Offer(i, distance);
      }
    }
  });
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < source.size(); ++i) {
    const int j = of_source[i].index;
    if (of_source[i].IsClear() && of_target[j].index == i) matches.push_back({i, j});
  }
  return matches;
}

GreyPyramid MakeGreyPyramid(const Image<Rgb8>& color) {
  GreyPyramid pyramid = {CoarseBrightness(color, 0).value};
  while (pyramid.size() < kLevels) pyramid.push_back(HalfResolution(pyramid.back()));
  return pyramid;
}

std::vector<Eigen::Vector2f> FindCorners(const GreyPyramid& grey, const Image<float>& depth_m,
                                         int max_count) {
  const cv::Size size(depth_m.width(), depth_m.height());
  const cv::Mat image(size, CV_32F, const_cast<float*>(grey.front().data()));
  const cv::Mat depth(size, CV_32F, const_cast<float*>(depth_m.data()));
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, max_count, kQuality, kApart_px, depth > 0);
  std::vector<Eigen::Vector2f> corners;
  corners.reserve(found.size());
  for (const cv::Point2f& corner : found) corners.emplace_back(corner.x, corner.y);
  return corners;
}

CornerTracks::CornerTracks(GreyPyramid first, std::vector<Eigen::Vector2f> corners)
    : first_(std::move(first)), last_(first_) {
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    tracks_.push_back({i, corners[i], corners[i]});
  }
}

void CornerTracks::Follow(GreyPyramid next, const Expect& expect) {
  std::vector<std::optional<Eigen::Vector2f>> places(tracks_.size());
  ParallelFor(0, static_cast<int>(tracks_.size()), kTracksPerBlock, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      places[i] = FindCorner(last_, tracks_[i].last, next, expect(tracks_[i]));
    }
  });
  std::vector<Track> found;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (places[i]) found.push_back({tracks_[i].corner, tracks_[i].first, *places[i]});
  }
  tracks_ = std::move(found);
  last_ = std::move(next);
}

std::vector<CornerTracks::Track> CornerTracks::Lasting(const Expect& expect) const {
  std::vector<Track> lasting;
  for (const Track& track : tracks_) {
    auto found = FindPatch(first_[0], track.first, last_[0], track.last);
    if (!found || found->alike <= kMinCorrelationFirst) continue;
    const auto expected = FindPatch(first_[0], track.first, last_[0], expect(track));
    if (expected && expected->alike > found->alike) found = expected;
    lasting.push_back({track.corner, track.first, found->at});
  }
  return lasting;
}

}  // namespace surfit
