#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "registration/global/feature_points.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/lanes.h"

namespace surfit {
namespace {

constexpr double kInlierSigmas = 3;
constexpr int kMinInliers = 4;
constexpr int kRefinements = 5;
constexpr double kMinSide = 0.05;  // m; smaller triangles do not constrain the rotation

// Set of matches, one bit per match.
struct InlierSet {
  std::vector<std::uint64_t> words;
  int count = 0;

  bool Contains(int match) const { return (words[match / 64] >> (match % 64)) & 1; }
};

// True if the sets have more than half of the smaller set in common.
bool ShareHalf(const InlierSet& a, const InlierSet& b) {
  int common = 0;
  WithInstructions([&](auto /*instructions*/) {
    for (std::size_t i = 0; i < a.words.size(); ++i) {
      common += static_cast<int>(std::bitset<64>(a.words[i] & b.words[i]).count());
    }
  });
  return 2 * common > std::min(a.count, b.count);
}

struct Hypothesis {
  Rigid3d target_from_source;
  InlierSet inliers;
};

class ConsensusSearch {
 public:
  ConsensusSearch(const FeaturePoints& source, const FeaturePoints& target,
                  const std::vector<FeatureMatch>& matches)
      : source_(source), target_(target), matches_(matches) {
    for (const FeatureMatch& match : matches) {
      for (int axis = 0; axis < 3; ++axis) {
        from_[axis].push_back(source.points[match.source][axis]);
        to_[axis].push_back(target.points[match.target][axis]);
      }
      variances_.push_back(std::pow(source.sigmas_m[match.source], 2) +
                           std::pow(target.sigmas_m[match.target], 2));
      bounds_.push_back(kInlierSigmas * kInlierSigmas * variances_.back());
    }
    // Further lanes are no inliers.
    const std::size_t padded = (matches.size() + 63) / 64 * 64;
    for (int axis = 0; axis < 3; ++axis) {
      from_[axis].resize(padded);
      to_[axis].resize(padded);
    }
    bounds_.resize(padded);
  }

  // Returns RANSAC poses in descending order of inlier counts. If counts are equal, the earlier
  // sample comes first.
  std::vector<Hypothesis> Draw(int max_tries) const {
    std::mt19937_64 generator(1);
    std::vector<Hypothesis> found;
    int tries = 0;
    for (int i = 0; i < kConsensusSamples && tries < max_tries; ++i) {
      std::vector<int> sample(3);
      for (int& match : sample) match = static_cast<int>(generator() % matches_.size());
      if (!IsRigid(sample)) continue;
      ++tries;
      Hypothesis hypothesis = At(FitPose(source_, target_, matches_, sample));
      if (hypothesis.inliers.count >= kMinInliers) found.push_back(std::move(hypothesis));
    }
    std::stable_sort(found.begin(), found.end(), [](const Hypothesis& a, const Hypothesis& b) {
      return a.inliers.count > b.inliers.count;
    });
    return found;
  }

  Hypothesis Refine(Hypothesis hypothesis) const {
    for (int i = 0; i < kRefinements; ++i) {
      Hypothesis next = At(FitPose(source_, target_, matches_, Indices(hypothesis.inliers)));
      if (next.inliers.count < hypothesis.inliers.count) break;
      hypothesis = std::move(next);
    }
    return hypothesis;
  }

  // Ascending indices of the matches.
  std::vector<int> Indices(const InlierSet& inliers) const {
    std::vector<int> indices;
    for (int i = 0; i < static_cast<int>(matches_.size()); ++i) {
      if (inliers.Contains(i)) indices.push_back(i);
    }
    return indices;
  }

 private:
  // True if the triangle of three matches has equal side lengths in both views, within noise. Sides
  // shorter than kMinSide are rejected. A repeated match has a side of length zero.
  bool IsRigid(const std::vector<int>& sample) const {
    for (int i = 0; i < 3; ++i) {
      const int a = sample[i], b = sample[(i + 1) % 3];
      const double before_m =
          (source_.points[matches_[a].source] - source_.points[matches_[b].source]).norm();
      const double after_m =
          (target_.points[matches_[a].target] - target_.points[matches_[b].target]).norm();
      const double bound_m = kInlierSigmas * std::sqrt(variances_[a] + variances_[b]);
      if (before_m < kMinSide || std::abs(after_m - before_m) > bound_m) return false;
    }
    return true;
  }

  Hypothesis At(const Rigid3d& pose) const {
    Hypothesis hypothesis{pose, {std::vector<std::uint64_t>(bounds_.size() / 64), 0}};
    WithInstructions(
        [&](auto instructions) { FindInliers(instructions, pose, &hypothesis.inliers); });
    return hypothesis;
  }

  template <typename Instructions>
  void FindInliers(Instructions /*instructions*/, const Rigid3d& pose, InlierSet* inliers) const {
    using L = Lanes<double, Instructions>;
    const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
    const Eigen::Vector3d& t = pose.translation;
    for (std::size_t i = 0; i < bounds_.size(); i += L::kCount) {
      const L x = L::Load(&from_[0][i]), y = L::Load(&from_[1][i]), z = L::Load(&from_[2][i]);
      const L dx = x * r(0, 0) + y * r(0, 1) + z * r(0, 2) + t[0] - L::Load(&to_[0][i]);
      const L dy = x * r(1, 0) + y * r(1, 1) + z * r(1, 2) + t[1] - L::Load(&to_[1][i]);
      const L dz = x * r(2, 0) + y * r(2, 1) + z * r(2, 2) + t[2] - L::Load(&to_[2][i]);
      const L is_inlier = Select(dx * dx + dy * dy + dz * dz < L::Load(&bounds_[i]), L(1.), L(0.));
      double flags[L::kCount];
      is_inlier.Store(flags);
      for (int k = 0; k < L::kCount; ++k) {
        const std::uint64_t bit = flags[k] != 0;
        inliers->words[i / 64] |= bit << (i % 64 + k);
        inliers->count += static_cast<int>(bit);
      }
    }
  }

  const FeaturePoints& source_;
  const FeaturePoints& target_;
  const std::vector<FeatureMatch>& matches_;
  // Per match: points by axis (m), variance and inlier bound of the squared distance (m^2). Points
  // and bounds are padded with zeros to a multiple of 64.
  std::vector<double> from_[3], to_[3];
  std::vector<double> variances_, bounds_;
};

}  // namespace

Rigid3d FitPose(const FeaturePoints& source, const FeaturePoints& target,
                const std::vector<FeatureMatch>& matches, const std::vector<int>& used) {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  std::vector<double> weights;
  weights.reserve(used.size());
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
  std::vector<Hypothesis> distinct;
  if (static_cast<int>(matches.size()) < kMinInliers) return {};
  const ConsensusSearch search(source, target, matches);
  const auto is_known = [&](const Hypothesis& hypothesis) {
    return std::any_of(distinct.begin(), distinct.end(), [&](const Hypothesis& known) {
      return ShareHalf(known.inliers, hypothesis.inliers);
    });
  };
  for (const Hypothesis& candidate : search.Draw(max_tries)) {
    if (static_cast<int>(distinct.size()) == max_count) break;
    if (is_known(candidate)) continue;
    Hypothesis refined = search.Refine(candidate);
    if (!is_known(refined)) distinct.push_back(std::move(refined));
  }
  std::vector<Consensus> found;
  found.reserve(distinct.size());
  for (const Hypothesis& hypothesis : distinct) {
    found.push_back({hypothesis.target_from_source, search.Indices(hypothesis.inliers)});
  }
  return found;
}

}  // namespace surfit
