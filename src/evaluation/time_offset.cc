#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "surfit/core/options.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

// Search range of 0.1 s: exposure, readout and transfer shift timestamps by less than three
// frame periods.
constexpr int kOffsetSteps = 20;   // in each direction
constexpr double kStep_s = 0.005;  // much shorter than the period of hand-held motion
constexpr double kTolerance_s = 1e-5;

double RmseAt(double offset_s, const Trajectory& ground_truth, const Trajectory& estimate,
              const MatchOptions& options) {
  const auto at = EvaluateTimeOffset(ground_truth, estimate, offset_s, options);
  return at ? at->ate.translation_m.rmse : std::numeric_limits<double>::infinity();
}

// Estimated poses with ground truth at all tested offsets, so that all offsets are compared over
// equal poses.
Trajectory CommonPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                       const MatchOptions& options) {
  Trajectory known;
  for (const StampedPose& pose : estimate) {
    bool throughout = true;
    for (int i = -kOffsetSteps; i <= kOffsetSteps && throughout; ++i) {
      throughout = InterpolatePose(ground_truth, pose.stamp_s + i * kStep_s, options.max_gap_s,
                                   options.max_difference_s)
                       .has_value();
    }
    if (throughout) known.push_back(pose);
  }
  return known;
}

// Stores the offset with the lowest RMSE, the first one if equal.
class Search {
 public:
  Search(const Trajectory& ground_truth, const Trajectory& estimate, const MatchOptions& options)
      : ground_truth_(ground_truth), estimate_(estimate), options_(options) {}

  double best_s() const { return best_s_; }

  double Try(double offset_s) {
    const double rmse_m = RmseAt(offset_s, ground_truth_, estimate_, options_);
    if (rmse_m < best_rmse_m_) {
      best_rmse_m_ = rmse_m;
      best_s_ = offset_s;
    }
    return rmse_m;
  }

  void Narrow(double begin_s, double end_s) {
    const double section = (std::sqrt(5.) - 1) / 2;
    std::array<double, 2> inner_s = {end_s - section * (end_s - begin_s),
                                     begin_s + section * (end_s - begin_s)};
    std::array<double, 2> rmse_m = {Try(inner_s[0]), Try(inner_s[1])};
    while (end_s - begin_s > kTolerance_s) {
      if (rmse_m[0] <= rmse_m[1]) {
        end_s = inner_s[1];
        const double left_s = end_s - section * (end_s - begin_s);
        inner_s = {left_s, inner_s[0]};
        rmse_m = {Try(left_s), rmse_m[0]};
      } else {
        begin_s = inner_s[0];
        const double right_s = begin_s + section * (end_s - begin_s);
        inner_s = {inner_s[1], right_s};
        rmse_m = {rmse_m[1], Try(right_s)};
      }
    }
  }

 private:
  const Trajectory& ground_truth_;
  const Trajectory& estimate_;
  const MatchOptions& options_;
  double best_s_ = 0;
  double best_rmse_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Trajectory WithTimeOffset(Trajectory trajectory, double by_s) {
  for (StampedPose& pose : trajectory) pose.stamp_s += by_s;
  return trajectory;
}

std::optional<TimeOffset> EvaluateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate, double offset_s,
                                             const MatchOptions& options) {
  const auto ate = ComputeAbsoluteTrajectoryError(
      MatchPoses(ground_truth, WithTimeOffset(estimate, offset_s), options));
  if (!ate) return std::nullopt;
  return TimeOffset{offset_s, *ate};
}

std::optional<TimeOffset> EstimateTimeOffset(const Trajectory& ground_truth,
                                             const Trajectory& estimate,
                                             const MatchOptions& options) {
  Validate(options);
  const Trajectory known = CommonPoses(ground_truth, estimate, options);
  if (known.size() < 3) return std::nullopt;
  Search search(ground_truth, known, options);
  search.Try(0);
  for (int i = 1; i <= kOffsetSteps; ++i) {
    search.Try(-i * kStep_s);
    search.Try(i * kStep_s);
  }
  const double coarse_s = search.best_s();
  search.Narrow(std::max(coarse_s - kStep_s, -kOffsetSteps * kStep_s),
                std::min(coarse_s + kStep_s, kOffsetSteps * kStep_s));
  return EvaluateTimeOffset(ground_truth, estimate, search.best_s(), options);
}

}  // namespace surfit
