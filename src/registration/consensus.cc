#include "registration/consensus.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <random>
#include <utility>

#include "registration/decompositions.h"

namespace surfit {
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
