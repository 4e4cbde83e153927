#include "tracking/motion/static_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "core/median.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"
#include "tracking/feature_watch.h"

namespace surfit {
namespace {

// Bound on the reprojection error of a static corner: tracking error, and the effect of readout and
// motion blur, which grows with the image motion.
constexpr double kCornerSigma_px = 0.5, kBoundPerShift = 0.05;
// A corner moves if its error is larger than the bound by this factor.
constexpr double kMovingFactor = 2.5;
// A pose contradicts the static corners if this ratio of them is farther from their place than
// kApartFactor bounds.
constexpr double kApartFactor = 1.5, kMinApartRatio = 0.5;
constexpr int kSamples = 300, kMinSample = 3, kSampleSteps = 3, kRefineSteps = 6;
constexpr int kSamplesPerBlock = 25;
// A motion with more than this ratio of the corners is not compared with random samples.
constexpr double kClearRatio = 0.75;
// Minimum support of a motion: blocks of the image, and ratio of all blocks with corners.
constexpr double kMinBlocks = 10, kMinSupport = 0.15;
// Minimum support of a motion that contradicts a pose.
constexpr double kCertainSupport = 0.25;
constexpr int kBlocksAcross = 16;
// Weight of a corner on an object that moved before.
constexpr double kWeightMoved = 0.25;
// Minimum support of a background motion relative to a nearer motion.
constexpr double kMinBehind = 0.5;

double BoundOf(const TrackedCorner& corner) {
  return 2 * kCornerSigma_px + kBoundPerShift * (corner.seen - corner.first).norm();
}

// Returns whether enough corners agree on a second motion, see FeatureMotion::HasTwoMotions().
bool HasSecondMotion(std::size_t static_count, std::size_t second_count) {
  FeatureMotion motion;
  motion.consistent_count = static_cast<int>(static_count);
  motion.apart = static_cast<int>(second_count);
  return motion.HasTwoMotions();
}

// Rigid motion with the corners within the bound, and their support: sum of the truncated quadratic
// scores, in blocks of the image.
struct MotionSupport {
  Rigid3d motion;
  double support = 0;
  std::vector<int> corners;
};

// Reprojection errors of all corners.
class MotionSearch {
 public:
  MotionSearch(const std::vector<TrackedCorner>& corners, const PinholeCamera& camera)
      : corners_(corners), camera_(camera), weights_(corners.size()) {
    std::map<std::pair<int, int>, int> count_of_block;
    const double block = static_cast<double>(camera.width) / kBlocksAcross;
    const auto block_of = [&](const TrackedCorner& corner) {
      return std::make_pair(static_cast<int>(corner.first.x() / block),
                            static_cast<int>(corner.first.y() / block));
    };
    for (const TrackedCorner& corner : corners) ++count_of_block[block_of(corner)];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      weights_[i] = 1. / count_of_block[block_of(corners[i])];
      if (corners[i].moved_before) weights_[i] *= kWeightMoved;
      bounds_.push_back(BoundOf(corners[i]));
    }
    block_count_ = static_cast<double>(count_of_block.size());
  }

  double block_count() const { return block_count_; }
  double weight(int corner) const { return weights_[corner]; }

  // In units of the bound of a static corner.
  double Error(int corner, const Rigid3d& motion) const {
    const Eigen::Vector3d point = motion * corners_[corner].point;
    if (!(point.z() > 0.05)) return std::numeric_limits<double>::infinity();
    return (camera_.Project(point) - corners_[corner].seen).norm() / bounds_[corner];
  }

  std::vector<int> Apart(const std::vector<int>& used, const Rigid3d& motion) const {
    std::vector<int> apart;
    std::copy_if(used.begin(), used.end(), std::back_inserter(apart),
                 [&](int i) { return Error(i, motion) > kMovingFactor; });
    return apart;
  }

  MotionSupport At(const std::vector<int>& used, const Rigid3d& motion) const {
    MotionSupport found = {motion, 0, {}};
    for (const int i : used) {
      const double error = Error(i, motion);
      if (!(error < 1)) continue;
      found.support += weights_[i] * (1 - error * error);
      found.corners.push_back(i);
    }
    return found;
  }

  // Returns the motion with the largest support among the corners `used`.
  MotionSupport Find(const std::vector<int>& used, const std::vector<Rigid3d>& initial) const {
    MotionSupport best = At(used, initial.front());
    const auto compare = [&](const Rigid3d& motion) {
      MotionSupport found = At(used, motion);
      if (found.support > best.support) best = std::move(found);
    };
    for (const Rigid3d& motion : initial) {
      compare(motion);
      compare(Refined(used, motion));
    }
    if (!IsClear(used, best)) {
      compare(BestSample(used, initial.front(), best.support));
      compare(Refined(used, best.motion));
    }
    return best;
  }

 private:
  // True if more than kClearRatio of the corners agree with the motion. No other motion has more.
  bool IsClear(const std::vector<int>& used, const MotionSupport& found) const {
    double all = 0, agreeing = 0;
    for (const int i : used) all += weights_[i];
    for (const int i : found.corners) agreeing += weights_[i];
    return agreeing > kClearRatio * all;
  }

  // Returns the motion with the largest support among those of random samples. Samples with less
  // support than `least` are not compared.
  Rigid3d BestSample(const std::vector<int>& used, const Rigid3d& initial, double least) const {
    std::mt19937_64 generator(1);
    std::vector<std::array<int, kMinSample>> samples(kSamples);
    for (auto& sample : samples) {
      for (int& corner : sample) corner = used[generator() % used.size()];
    }
    std::vector<Rigid3d> motions(kSamples, initial);
    std::vector<double> supports(kSamples);
    ParallelFor(0, kSamples, kSamplesPerBlock, [&](int begin, int end) {
      double most = least;
      for (int i = begin; i < end; ++i) {
        for (int step = 0; step < kSampleSteps; ++step) {
          motions[i] = Step(samples[i], motions[i], false);
        }
        supports[i] = SupportOf(used, motions[i], most);
        most = std::max(most, supports[i]);
      }
    });
    return motions[std::max_element(supports.begin(), supports.end()) - supports.begin()];
  }

  // Returns the support of a motion, or a value below `least` if the support is below `least`.
  double SupportOf(const std::vector<int>& used, const Rigid3d& motion, double least) const {
    constexpr double kRounding = 1e-9;
    double support = 0, possible = 0;
    for (const int i : used) possible += weights_[i];
    for (const int i : used) {
      possible -= weights_[i];
      const double error = Error(i, motion);
      if (error < 1) support += weights_[i] * (1 - error * error);
      if (support + possible < least - kRounding) break;
    }
    return support;
  }

  Rigid3d Refined(const std::vector<int>& used, Rigid3d motion) const {
    for (int step = 0; step < kRefineSteps; ++step) motion = Step(used, motion, true);
    return motion;
  }

  // Gauss-Newton step of the reprojection error. With `robust`, only static corners count.
  template <typename Corners>
  Rigid3d Step(const Corners& used, const Rigid3d& motion, bool robust) const {
    Matrix6d normal = 1e-9 * Matrix6d::Identity();
    Vector6d right = Vector6d::Zero();
    for (const int i : used) {
      const Eigen::Vector3d point = motion * corners_[i].point;
      if (!(point.z() > 0.05)) continue;
      const Eigen::Vector2d residual = camera_.Project(point) - corners_[i].seen;
      const double bound = bounds_[i];
      if (robust && residual.norm() > 2 * bound) continue;
      Eigen::Matrix<double, 2, 3> projection;
      const double z = point.z();
      projection << camera_.fx / z, 0, -camera_.fx * point.x() / (z * z), 0, camera_.fy / z,
          -camera_.fy * point.y() / (z * z);
      Eigen::Matrix<double, 2, 6> row;
      row.leftCols<3>() = -projection * CrossMatrix<double>(point);
      row.rightCols<3>() = projection;
      const double weight = weights_[i] / (bound * bound);
      normal += weight * row.transpose() * row;
      right -= weight * row.transpose() * residual;
    }
    const Vector6d increment = SolveLdlt(normal, right);
    if (!increment.allFinite() || increment.head<3>().norm() > 1) return motion;
    return LeftIncrement<double>(increment, motion);
  }

  const std::vector<TrackedCorner>& corners_;
  const PinholeCamera& camera_;
  std::vector<double> weights_, bounds_;
  double block_count_ = 0;
};

double MedianDepth(const std::vector<TrackedCorner>& corners, const std::vector<int>& used) {
  std::vector<double> depths;
  depths.reserve(used.size());
  for (const int i : used) depths.push_back(corners[i].point.z());
  return MedianOf(std::move(depths));
}

}  // namespace

CornerMotion FindStaticMotion(const std::vector<TrackedCorner>& corners,
                              const PinholeCamera& camera, const Rigid3d& expected) {
  if (corners.size() < kMinBlocks) return {};
  const MotionSearch search(corners, camera);
  std::vector<int> all(corners.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  MotionSupport found = search.Find(all, {expected, Rigid3d()});
  MotionSupport other;
  const std::vector<int> apart = search.Apart(all, found.motion);
  if (apart.size() >= kMinSample && !found.corners.empty()) {
    other = search.Find(apart, {expected, Rigid3d()});
    const bool is_behind = !other.corners.empty() && MedianDepth(corners, other.corners) >
                                                         MedianDepth(corners, found.corners);
    if (is_behind && other.support >= kMinBehind * found.support) {
      std::swap(found, other);
      found = search.At(all, found.motion);
    }
  }
  if (found.support < kMinBlocks || found.support < kMinSupport * search.block_count()) return {};
  CornerMotion motion;
  motion.now_from_before = found.motion;
  motion.is_certain = found.support >= kCertainSupport * search.block_count() &&
                      HasSecondMotion(found.corners.size(), other.corners.size());
  for (const int i : all) {
    const double error = search.Error(i, found.motion);
    motion.labels.push_back(error < 1               ? CornerMotion::Label::kStatic
                            : error > kMovingFactor ? CornerMotion::Label::kMoving
                                                    : CornerMotion::Label::kUnknown);
  }
  return motion;
}

bool ContradictsStaticCorners(const std::vector<TrackedCorner>& corners, const CornerMotion& motion,
                              const PinholeCamera& camera, const Rigid3d& now_from_before) {
  const MotionSearch search(corners, camera);
  double all = 0, apart = 0;
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    if (motion.labels[i] != CornerMotion::Label::kStatic) continue;
    all += search.weight(i);
    if (search.Error(i, now_from_before) > kApartFactor) apart += search.weight(i);
  }
  return apart > kMinApartRatio * all;
}

}  // namespace surfit
