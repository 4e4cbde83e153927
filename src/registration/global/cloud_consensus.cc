#include <algorithm>
#include <cmath>
#include <cstdint>

#include "registration/global/cloud_features.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kSeeds = 1000;             // maximum number of seeds: the best matches
constexpr int kFittedMatches = 30;       // maximum number of fitted matches per seed
constexpr int kLeastCompatible = 3;      // minimum number of compatible matches of a seed
constexpr float kMaxAngleCosine = 0.3f;  // maximum difference of the cosines of the normal angles

// Number of set bits, by sums of neighbouring fields. Processors without an own instruction would
// call a library function.
int CountBits(std::uint64_t bits) {
  bits -= (bits >> 1) & 0x5555555555555555;
  bits = (bits & 0x3333333333333333) + ((bits >> 2) & 0x3333333333333333);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return static_cast<int>((bits * 0x0101010101010101) >> 56);
}

// Compatibility graph of the matches, one row of bits per match.
class MatchGraph {
 public:
  explicit MatchGraph(int count) : words_((count + 63) / 64), bits_(count * words_, 0) {}

  void Set(int row, int column) { bits_[row * words_ + column / 64] |= Bit(column); }
  bool Has(int row, int column) const {
    return (bits_[row * words_ + column / 64] & Bit(column)) != 0;
  }
  int CountCommon(int a, int b) const {
    int count = 0;
    for (std::size_t k = 0; k < words_; ++k) {
      count += CountBits(bits_[a * words_ + k] & bits_[b * words_ + k]);
    }
    return count;
  }

 private:
  static std::uint64_t Bit(int column) { return std::uint64_t{1} << (column % 64); }

  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

class KeyConsensusFinder {
 public:
  KeyConsensusFinder(const KeyPoints& source, const KeyPoints& target,
                     const std::vector<KeyMatch>& matches, double tolerance_m)
      : source_(source),
        target_(target),
        matches_(matches),
        count_(static_cast<int>(matches.size())),
        tolerance_m_(tolerance_m),
        graph_(count_) {
    ParallelFor(0, count_, 16, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        for (int k = 0; k < count_; ++k) {
          if (Compatible(i, k)) graph_.Set(i, k);
        }
      }
    });
  }

  std::vector<KeyConsensus> Find(int max_count) const {
    std::vector<KeyConsensus> all(std::min(count_, kSeeds));
    ParallelFor(0, static_cast<int>(all.size()), 8, [&](int begin, int end) {
      for (int seed = begin; seed < end; ++seed) all[seed] = FromSeed(seed);
    });
    std::stable_sort(all.begin(), all.end(), [](const KeyConsensus& a, const KeyConsensus& b) {
      return a.inliers > b.inliers;
    });
    std::vector<KeyConsensus> distinct;
    for (const KeyConsensus& candidate : all) {
      if (static_cast<int>(distinct.size()) == max_count || candidate.inliers < 3) break;
      const bool is_new = std::none_of(distinct.begin(), distinct.end(), [&](const auto& other) {
        return AreAlike(candidate.target_from_source, other.target_from_source);
      });
      if (is_new) distinct.push_back(candidate);
    }
    return distinct;
  }

 private:
  const Eigen::Vector3f& p(int i) const { return source_.points[matches_[i].source]; }
  const Eigen::Vector3f& q(int i) const { return target_.points[matches_[i].target]; }

  bool Compatible(int i, int k) const {
    const float in_source = (p(i) - p(k)).norm(), in_target = (q(i) - q(k)).norm();
    const auto tolerance = static_cast<float>(tolerance_m_);
    if (!(std::abs(in_source - in_target) < tolerance) || in_source < 2 * tolerance) return false;
    const float angle =
        source_.normals[matches_[i].source].dot(source_.normals[matches_[k].source]);
    const float other =
        target_.normals[matches_[i].target].dot(target_.normals[matches_[k].target]);
    return std::abs(angle - other) < kMaxAngleCosine;
  }

  KeyConsensus FromSeed(int seed) const {
    std::vector<std::pair<int, int>> ranked;  // common neighbours (negative), match
    for (int i = 0; i < count_; ++i) {
      if (graph_.Has(seed, i)) ranked.emplace_back(-graph_.CountCommon(seed, i), i);
    }
    KeyConsensus result;
    if (static_cast<int>(ranked.size()) < kLeastCompatible) return result;
    const std::size_t fitted = std::min<std::size_t>(ranked.size(), kFittedMatches);
    std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(fitted),
                      ranked.end());
    ranked.resize(fitted);
    std::vector<int> used = {seed};
    for (const auto& [common, i] : ranked) used.push_back(i);
    for (int round = 0; round < 3; ++round) {
      const Rigid3d pose = Fit(used);
      std::vector<int> inliers = Inliers(pose);
      if (static_cast<int>(inliers.size()) <= result.inliers) break;
      result = {pose, static_cast<int>(inliers.size())};
      if (inliers.size() < 3) break;
      used = std::move(inliers);
    }
    return result;
  }

  // Least-squares fit (Kabsch 1976).
  Rigid3d Fit(const std::vector<int>& used) const {
    Eigen::Vector3d source_mean = Eigen::Vector3d::Zero(), target_mean = source_mean;
    for (const int i : used) {
      source_mean += p(i).cast<double>();
      target_mean += q(i).cast<double>();
    }
    source_mean /= static_cast<double>(used.size());
    target_mean /= static_cast<double>(used.size());
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (const int i : used) {
      products +=
          (q(i).cast<double>() - target_mean) * (p(i).cast<double>() - source_mean).transpose();
    }
    const Eigen::Matrix3d rotation = NearestRotation(products);
    return Rigid3d(rotation, target_mean - rotation * source_mean);
  }

  std::vector<int> Inliers(const Rigid3d& pose) const {
    const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix().cast<float>();
    const Eigen::Vector3f translation = pose.translation.cast<float>();
    const auto tolerance2 = static_cast<float>(tolerance_m_ * tolerance_m_);
    std::vector<int> inliers;
    for (int i = 0; i < count_; ++i) {
      if ((rotation * p(i) + translation - q(i)).squaredNorm() < tolerance2) inliers.push_back(i);
    }
    return inliers;
  }

  bool AreAlike(const Rigid3d& a, const Rigid3d& b) const {
    constexpr double kAngleRad = 0.1;
    const Eigen::Vector3d center = source_.points[source_.points.size() / 2].cast<double>();
    return (a * center - b * center).norm() < 3 * tolerance_m_ &&
           RotationAngle(a.rotation.conjugate() * b.rotation) < kAngleRad;
  }

  const KeyPoints& source_;
  const KeyPoints& target_;
  const std::vector<KeyMatch>& matches_;
  int count_;
  double tolerance_m_;
  MatchGraph graph_;
};

}  // namespace

std::vector<KeyConsensus> FindKeyConsensus(const KeyPoints& source, const KeyPoints& target,
                                           const std::vector<KeyMatch>& matches, double tolerance_m,
                                           int max_count) {
  return KeyConsensusFinder(source, target, matches, tolerance_m).Find(max_count);
}

}  // namespace surfit
