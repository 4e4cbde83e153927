#include "slam/belief.h"

#include <cmath>

namespace surfit {
namespace {

// Of the points that model and frame both show, so many may contradict each other. Where the pose
// is right, of 99 in 100 frames fewer than kSureShare do; where it is wrong by more than 10 cm,
// more than kMostShare do unless wrong frames have been fused before.
constexpr double kSureShare = 0.12, kMostShare = 0.25;
// Where much moves the rest must agree all the better.
constexpr double kSureRest = 0.08;
// Correlations of brightness, likewise.
constexpr double kSureAlike = 0.5, kLeastAlike = 0.3;

}  // namespace

Verdict Belief::Judge(const IcpResult& icp, const ViewComparison& views, int moving) const {
  if (!IsRegistered(icp)) return Verdict::kRefuted;
  if (views.compared <= moving) return Verdict::kRefuted;
  const double all = static_cast<double>(views.in_front + views.behind) / views.compared;
  const double rest =
      static_cast<double>(views.in_front - moving + views.behind) / (views.compared - moving);
  const bool agrees = all <= kSureShare || (moving > 0 && rest <= kSureRest);
  if (views.alike < kLeastAlike) return Verdict::kRefuted;
  if (agrees && views.alike >= kSureAlike) return Verdict::kBelieved;
  const bool may_agree = all <= kMostShare && (all <= kSureShare || views.alike >= kSureAlike);
  return agrees || may_agree ? Verdict::kDoubtful : Verdict::kRefuted;
}

bool Belief::IsRegistered(const IcpResult& icp) const {
  const bool is_degenerate = icp.termination == Termination::kSingularSystem;
  return (icp.Succeeded() || is_degenerate) && icp.inlier_share >= options_.min_inlier_share &&
         icp.rmse_m <= options_.max_rmse_m;
}

bool Belief::IsPossible(const Rigid3d& motion, double seconds) {
  constexpr double kAtOnce_m = 0.1, kMetresPerSecond = 3;
  constexpr double kAtOnce_rad = 0.2, kRadPerSecond = 6;
  return motion.translation.norm() <= kAtOnce_m + kMetresPerSecond * seconds &&
         RotationAngle(motion.rotation) <= kAtOnce_rad + kRadPerSecond * seconds;
}

}  // namespace surfit
