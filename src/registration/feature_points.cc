#include "registration/feature_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <utility>

#include "registration/decompositions.h"

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

namespace {

constexpr double kInlierSigmas = 3;
constexpr std::size_t kMinInliers = 4;
constexpr int kRefinements = 5;
constexpr double kMinSide = 0.05;  // m; smaller triangles hold no rotation

class ConsensusSearch {
 public:
  ConsensusSearch(const FeaturePoints& source, const FeaturePoints& target,
                  const std::vector<FeatureMatch>& matches)
      : source_(source), target_(target), matches_(matches) {}

  // In descending order of their inliers, first drawn first.
  std::vector<Consensus> Draw(int max_tries) const {
    std::mt19937_64 generator(1);
    std::vector<Consensus> found;
    int tries = 0;
    for (int i = 0; i < kConsensusSamples && tries < max_tries; ++i) {
      std::vector<int> sample(3);
      for (int& match : sample) match = static_cast<int>(generator() % matches_.size());
      if (!IsRigid(sample)) continue;
      ++tries;
      Consensus consensus = At(FitPose(source_, target_, matches_, sample));
      if (consensus.inliers.size() >= kMinInliers) found.push_back(std::move(consensus));
    }
    std::stable_sort(found.begin(), found.end(), [](const Consensus& a, const Consensus& b) {
      return a.inliers.size() > b.inliers.size();
    });
    return found;
  }

  Consensus Refine(Consensus consensus) const {
    for (int i = 0; i < kRefinements; ++i) {
      Consensus next = At(FitPose(source_, target_, matches_, consensus.inliers));
      if (next.inliers.size() < consensus.inliers.size()) break;
      consensus = std::move(next);
    }
    return consensus;
  }

 private:
  double Variance(const FeatureMatch& match) const {
    return std::pow(source_.sigmas_m[match.source], 2) +
           std::pow(target_.sigmas_m[match.target], 2);
  }

  // Sides are as long in both views, and long enough. Two equal matches make a side of no length.
  bool IsRigid(const std::vector<int>& sample) const {
    for (int i = 0; i < 3; ++i) {
      const FeatureMatch &a = matches_[sample[i]], &b = matches_[sample[(i + 1) % 3]];
      const double before_m = (source_.points[a.source] - source_.points[b.source]).norm();
      const double after_m = (target_.points[a.target] - target_.points[b.target]).norm();
      const double bound_m = kInlierSigmas * std::sqrt(Variance(a) + Variance(b));
      if (before_m < kMinSide || std::abs(after_m - before_m) > bound_m) return false;
    }
    return true;
  }

  Consensus At(const Rigid3d& pose) const {
    Consensus consensus{pose, {}};
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    for (int i = 0; i < static_cast<int>(matches_.size()); ++i) {
      const Eigen::Vector3d moved =
          rotation * source_.points[matches_[i].source] + pose.translation;
      const double square = (moved - target_.points[matches_[i].target]).squaredNorm();
      if (square < kInlierSigmas * kInlierSigmas * Variance(matches_[i])) {
        consensus.inliers.push_back(i);
      }
    }
    return consensus;
  }

  const FeaturePoints& source_;
  const FeaturePoints& target_;
  const std::vector<FeatureMatch>& matches_;
};

bool ShareHalf(const Consensus& a, const Consensus& b) {
  std::vector<int> common;
  std::set_intersection(a.inliers.begin(), a.inliers.end(), b.inliers.begin(), b.inliers.end(),
                        std::back_inserter(common));
  return 2 * common.size() > std::min(a.inliers.size(), b.inliers.size());
}

}  // namespace

Rigid3d FitPose(const FeaturePoints& source, const FeaturePoints& target,
                const std::vector<FeatureMatch>& matches, const std::vector<int>& used) {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  std::vector<double> weights;
  double weight_sum = 0;
  for (const int i : used) {
    const auto& [s, t] = matches[i];
    weights.push_back(1 / (std::pow(source.sigmas_m[s], 2) + std::pow(target.sigmas_m[t], 2)));
    weight_sum += weights.back();
    from += weights.back() * source.points[s];
    to += weights.back() * target.points[t];
  }
  from /= weight_sum;
  to /= weight_sum;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < used.size(); ++i) {
    const auto& [s, t] = matches[used[i]];
    covariance += weights[i] * (target.points[t] - to) * (source.points[s] - from).transpose();
  }
  const Eigen::Matrix3d rotation = NearestRotation(covariance);
  return Rigid3d(rotation, to - rotation * from);
}

std::vector<Consensus> FindConsensus(const FeaturePoints& source, const FeaturePoints& target,
                                     const std::vector<FeatureMatch>& matches, int max_count,
                                     int max_tries) {
  std::vector<Consensus> distinct;
  if (matches.size() < kMinInliers) return distinct;
  const ConsensusSearch search(source, target, matches);
  const auto is_known = [&](const Consensus& consensus) {
    return std::any_of(distinct.begin(), distinct.end(),
                       [&](const Consensus& known) { return ShareHalf(known, consensus); });
  };
  for (const Consensus& candidate : search.Draw(max_tries)) {
    if (static_cast<int>(distinct.size()) == max_count) break;
    if (is_known(candidate)) continue;
    Consensus refined = search.Refine(candidate);
    if (!is_known(refined)) distinct.push_back(std::move(refined));
  }
  return distinct;
}

}  // namespace surfit
