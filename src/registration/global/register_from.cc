#include "registration/global/register_from.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

constexpr double kRivalShiftM = 0.1;  // shift along the weakest direction

struct Fit {
  Rigid3d start;
  IcpResult icp;
  ViewFit view;

  const Rigid3d& pose() const { return icp.target_from_source; }
};

struct ScoredPose {
  Rigid3d target_from_source;
  double score;  // ViewFit::Score()
};

double MeanDepth(const FrameLevel& level) {
  double sum = 0;
  int count = 0;
  for (const float z : level.vertex.z) {
    if (z > 0) sum += z, ++count;
  }
  return count > 0 ? sum / count : 0;
}

class FarRegistration {
 public:
  FarRegistration(const GlobalView& source, const GlobalView& target,
                  const GlobalRegistrationOptions& options, const GlobalRegistrationResult& verdict)
      : source_(source), target_(target), options_(options), verdict_(verdict) {}

  GlobalRegistrationResult From(const std::vector<Rigid3d>& starts) {
    for (const Rigid3d& start : starts) RegisterFromStart(start);
    verdict_.reason = Judge();
    return std::move(verdict_);
  }

 private:
  GlobalRegistrationReason Judge() {
    if (fits_.empty()) return Failure();
    const Fit best = *std::max_element(fits_.begin(), fits_.end(), [](const Fit& a, const Fit& b) {
      return a.view.Score() < b.view.Score();
    });
    Describe(best);
    if (const auto doubt = CheckViews()) return *doubt;
    if (&source_.finest != &source_.pyramid) {
      verdict_.icp = Register(source_.finest, target_.finest, best.pose(), options_.icp);
    }
    Describe(verdict_.icp);
    if (const auto doubt = CheckRegistration()) return *doubt;
    MeasureScoreMargin(best);
    if (verdict_.score_margin < options_.fit.min_score_margin)
      return GlobalRegistrationReason::kAmbiguous;
    if (options_.fit.max_disagreement_rad < M_PI) MeasureDisagreement(best.pose());
    if (verdict_.disagreement_m > options_.fit.max_disagreement_m ||
        verdict_.disagreement_rad > options_.fit.max_disagreement_rad) {
      return GlobalRegistrationReason::kInconsistent;
    }
    verdict_.information = SymmetricInverse(RealisticCovariance(
        *verdict_.icp.covariance, verdict_.disagreement_rad, verdict_.disagreement_m));
    return GlobalRegistrationReason::kAccepted;
  }

  // Registers from one initial pose. A pose with free-space violations cannot be accepted, but its
  // score still reduces the score margin of other poses.
  void RegisterFromStart(const Rigid3d& start) {
    IcpResult icp = Register(source_.pyramid, target_.pyramid, start, options_.icp_from_start);
    is_degenerate_ = is_degenerate_ || icp.termination == Termination::kSingularSystem;
    const bool succeeded = icp.Succeeded();
    if (succeeded || icp.termination == Termination::kFreeSpaceViolation) {
      const ViewFit view = MeasureFit(source_.level, target_.level,
                                      options_.icp_from_start.error_model, icp.target_from_source);
      poses_.push_back({icp.target_from_source, view.Score()});
      if (succeeded) fits_.push_back({start, icp, view});
    }
    if (!succeeded && !first_failure_) first_failure_ = {start, std::move(icp), {}};
  }

  GlobalRegistrationReason Failure() {
    if (first_failure_) {
      verdict_.start = first_failure_->start;
      verdict_.icp = first_failure_->icp;
    }
    if (is_degenerate_) return GlobalRegistrationReason::kDegenerate;
    const bool filled = verdict_.icp.termination == Termination::kFreeSpaceViolation;
    return filled ? GlobalRegistrationReason::kFreeSpaceViolation
                  : GlobalRegistrationReason::kNotRegistered;
  }

  void Describe(const Fit& fit) {
    verdict_.start = fit.start;
    verdict_.icp = fit.icp;
    verdict_.target_from_source = fit.pose();
    verdict_.overlap_ratio = fit.view.overlap_ratio;
    verdict_.free_space_violation_ratio = fit.view.free_space_violation_ratio;
    verdict_.value_correlation = fit.view.value_correlation;
    verdict_.detail_correlation = fit.view.detail_correlation;
  }

  std::optional<GlobalRegistrationReason> CheckViews() const {
    const FitCriteria& fit = options_.fit;
    if (verdict_.overlap_ratio < fit.min_overlap_ratio)
      return GlobalRegistrationReason::kLittleOverlap;
    if (verdict_.free_space_violation_ratio > fit.max_free_space_violation_ratio)
      return GlobalRegistrationReason::kFreeSpaceViolation;
    const bool have_color = source_.has_color && target_.has_color;
    const bool look_alike = verdict_.value_correlation >= fit.min_value_correlation &&
                            verdict_.detail_correlation >= fit.min_detail_correlation;
    if (have_color ? !look_alike : fit.needs_color)
      return GlobalRegistrationReason::kLooksDifferent;
    return std::nullopt;
  }

  void Describe(const IcpResult& icp) {
    verdict_.target_from_source = icp.target_from_source;
    verdict_.inlier_ratio = icp.inlier_ratio;
    verdict_.rmse_m = icp.rmse_m;
    if (!icp.covariance) return;
    verdict_.sigma_rad = LargestSigma(icp.covariance->topLeftCorner<3, 3>());
    verdict_.sigma_m = LargestSigma(icp.covariance->bottomRightCorner<3, 3>());
  }

  std::optional<GlobalRegistrationReason> CheckRegistration() const {
    const FitCriteria& fit = options_.fit;
    if (verdict_.icp.termination == Termination::kSingularSystem)
      return GlobalRegistrationReason::kDegenerate;
    if (!verdict_.icp.Succeeded()) return GlobalRegistrationReason::kNotRegistered;
    if (verdict_.sigma_m > fit.max_sigma_m || verdict_.sigma_rad > fit.max_sigma_rad) {
      return GlobalRegistrationReason::kDegenerate;
    }
    if (verdict_.rmse_m > fit.max_rmse_m ||
        verdict_.inlier_ratio < fit.min_inlier_ratio * verdict_.overlap_ratio) {
      return GlobalRegistrationReason::kPoorFit;
    }
    return std::nullopt;
  }

  void MeasureScoreMargin(const Fit& best) {
    const IcpResult icp = verdict_.icp;
    const std::optional<Vector6d> weakest =
        WeakestIncrement(icp.information, MeanDepth(target_.finest.levels.front()));
    if (!weakest) return;
    for (const double shift_m : {-kRivalShiftM, kRivalShiftM}) {
      RegisterFromStart(LeftIncrement<double>(shift_m * *weakest, icp.target_from_source));
    }
    double rival = 0;
    for (const ScoredPose& pose : poses_) {
      if (!AreSame(pose.target_from_source, icp.target_from_source)) {
        rival = std::max(rival, pose.score);
      }
    }
    verdict_.score_margin = best.view.Score() > 0 ? 1 - rival / best.view.Score() : 0;
  }

  void MeasureDisagreement(const Rigid3d& start) {
    const IcpResult back = Register(target_.finest, source_.finest, start.Inverse(), options_.icp);
    const Rigid3d difference = verdict_.target_from_source * back.target_from_source;
    verdict_.disagreement_m = difference.translation.norm();
    verdict_.disagreement_rad = back.Succeeded() ? RotationAngle(difference.rotation) : M_PI;
  }

  const GlobalView& source_;
  const GlobalView& target_;
  const GlobalRegistrationOptions& options_;
  GlobalRegistrationResult verdict_;
  std::vector<Fit> fits_;          // successful registrations
  std::vector<ScoredPose> poses_;  // fits_ and other candidate poses
  // Failed registration of the first initial pose that failed. Initial poses are sorted, so this is
  // the most promising failure.
  std::optional<Fit> first_failure_;
  bool is_degenerate_ = false;  // an initial pose led to a degenerate system
};

}  // namespace

GlobalRegistrationResult RegisterFrom(const std::vector<Rigid3d>& starts, const GlobalView& source,
                                      const GlobalView& target,
                                      const GlobalRegistrationOptions& options,
                                      const GlobalRegistrationResult& verdict) {
  return FarRegistration(source, target, options, verdict).From(starts);
}

bool AreSame(const Rigid3d& a, const Rigid3d& b) {
  constexpr double kDistanceM = 0.04, kAngleRad = 0.035;
  return (a.translation - b.translation).norm() < kDistanceM &&
         RotationAngle(a.rotation.conjugate() * b.rotation) < kAngleRad;
}

Matrix6d RealisticCovariance(const Matrix6d& covariance, double disagreement_rad,
                             double disagreement_m) {
  // The errors of all loop closures in simulated rooms are below three standard deviations of this
  // covariance. Loop closures of a real Kinect have similar errors.
  constexpr double kFloorRad = 0.002, kFloorM = 0.004;
  Matrix6d realistic = kSharedPoints * covariance;
  realistic.diagonal().head<3>().array() +=
      kFloorRad * kFloorRad + disagreement_rad * disagreement_rad;
  realistic.diagonal().tail<3>().array() += kFloorM * kFloorM + disagreement_m * disagreement_m;
  return realistic;
}

}  // namespace surfit
