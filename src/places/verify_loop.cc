#include "surfit/places/verify_loop.h"

#include <algorithm>
#include <cmath>

#include "places/expanded_view.h"
#include "places/loop_covariance.h"
#include "places/loop_starts.h"
#include "registration/decompositions.h"
#include "registration/view_fit.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr double kRivalShiftM = 0.1;  // of the starts to both sides of the best pose
// Poses nearer to each other than this are one.
constexpr double kSameDistanceM = 0.04;
constexpr double kSameAngleRad = 0.035;

// A pose found on the coarser levels, and how well the views agree there.
struct CoarsePose {
  Rigid3d target_from_source;
  ViewFit fit;
};

bool AreSame(const Rigid3d& a, const Rigid3d& b) {
  return (a.translation - b.translation).norm() < kSameDistanceM &&
         RotationAngle(a.rotation.conjugate() * b.rotation) < kSameAngleRad;
}

double MeanDepth(const FrameLevel& level) {
  double sum = 0;
  int count = 0;
  for (const float z : level.vertex.z) {
    if (z > 0) sum += z, ++count;
  }
  return count > 0 ? sum / count : 0;
}

// Registers two views from given starts and looks for reasons to refuse the best fit.
class LoopVerifier {
 public:
  LoopVerifier(const PlaceView& source, const PlaceView& target, const VerifyLoopOptions& options)
      : source_(Expand(source, options.preprocess)),
        target_(Expand(target, options.preprocess)),
        options_(options),
        coarse_icp_(options.icp) {
    coarse_icp_.gates.max_distance_m *= options.icp.gate_growth;
    coarse_icp_.error_model.floor_sigma_m *= 2;
  }

  // Adds what it finds to a verdict.
  LoopVerdict Verify(const std::vector<Rigid3d>& starts, const LoopVerdict& verdict) {
    verdict_ = verdict;
    for (const Rigid3d& start : starts) RegisterCoarsely(start);
    if (poses_.empty()) {
      return With(is_degenerate_ ? LoopReason::kDegenerate : LoopReason::kNotRegistered);
    }
    const CoarsePose best = *std::max_element(
        poses_.begin(), poses_.end(),
        [](const auto& a, const auto& b) { return a.fit.Score() < b.fit.Score(); });
    Describe(best);
    if (const auto doubt = DoubtAboutViews()) return With(*doubt);
    const IcpResult icp =
        Register(source_.finest, target_.finest, best.target_from_source, options_.icp);
    Describe(icp);
    if (const auto doubt = DoubtAboutFit(icp)) return With(*doubt);
    MeasureLead(icp, best);
    if (verdict_.lead < options_.min_lead) return With(LoopReason::kAmbiguous);
    MeasureDisagreement(best.target_from_source);
    if (verdict_.disagreement_m > options_.max_disagreement_m ||
        verdict_.disagreement_rad > options_.max_disagreement_rad) {
      return With(LoopReason::kInconsistent);
    }
    verdict_.information = SymmetricInverse(
        LoopCovariance(*icp.covariance, verdict_.disagreement_rad, verdict_.disagreement_m));
    return With(LoopReason::kAccepted);
  }

 private:
  LoopVerdict With(LoopReason reason) const {
    LoopVerdict verdict = verdict_;
    verdict.reason = reason;
    return verdict;
  }

  void RegisterCoarsely(const Rigid3d& start) {
    const IcpResult icp = Register(source_.coarser, target_.coarser, start, coarse_icp_);
    is_degenerate_ = is_degenerate_ || icp.termination == Termination::kSingularSystem;
    if (!icp.Succeeded()) return;
    poses_.push_back(
        {icp.target_from_source, MeasureFit(source_.Level(), target_.Level(),
                                            coarse_icp_.error_model, icp.target_from_source)});
  }

  void Describe(const CoarsePose& pose) {
    verdict_.target_from_source = pose.target_from_source;
    verdict_.overlap_share = pose.fit.overlap_share;
    verdict_.free_space_share = pose.fit.free_space_share;
    verdict_.value_correlation = pose.fit.value_correlation;
    verdict_.detail_correlation = pose.fit.detail_correlation;
  }

  std::optional<LoopReason> DoubtAboutViews() const {
    if (verdict_.overlap_share < options_.min_overlap_share) return LoopReason::kLittleOverlap;
    if (verdict_.free_space_share > options_.max_free_space_share) {
      return LoopReason::kFreeSpaceFilled;
    }
    if (!source_.has_color || !target_.has_color ||
        verdict_.value_correlation < options_.min_value_correlation ||
        verdict_.detail_correlation < options_.min_detail_correlation) {
      return LoopReason::kLooksDifferent;
    }
    return std::nullopt;
  }

  void Describe(const IcpResult& icp) {
    verdict_.target_from_source = icp.target_from_source;
    verdict_.inlier_share = icp.inlier_share;
    verdict_.rmse_m = icp.rmse_m;
    if (!icp.covariance) return;
    verdict_.sigma_rad = LargestSigma(icp.covariance->topLeftCorner<3, 3>());
    verdict_.sigma_m = LargestSigma(icp.covariance->bottomRightCorner<3, 3>());
  }

  std::optional<LoopReason> DoubtAboutFit(const IcpResult& icp) const {
    if (icp.termination == Termination::kSingularSystem) return LoopReason::kDegenerate;
    if (!icp.Succeeded()) return LoopReason::kNotRegistered;
    if (verdict_.sigma_m > options_.max_sigma_m || verdict_.sigma_rad > options_.max_sigma_rad) {
      return LoopReason::kDegenerate;
    }
    if (icp.rmse_m > options_.max_rmse_m ||
        icp.inlier_share < options_.min_inlier_share * verdict_.overlap_share) {
      return LoopReason::kPoorFit;
    }
    return std::nullopt;
  }

  // Other starts, also to both sides along what the data holds least, must lead to the same pose
  // or to a worse one.
  void MeasureLead(const IcpResult& icp, const CoarsePose& best) {
    const Vector6d weakest =
        WeakestIncrement(icp.information, MeanDepth(target_.finest.levels.front()));
    for (const double shift_m : {-kRivalShiftM, kRivalShiftM}) {
      RegisterCoarsely(LeftIncrement<double>(shift_m * weakest, icp.target_from_source));
    }
    double rival = 0;
    for (const CoarsePose& pose : poses_) {
      if (AreSame(pose.target_from_source, icp.target_from_source)) continue;
      rival = std::max(rival, pose.fit.Score());
    }
    verdict_.lead = best.fit.Score() > 0 ? 1 - rival / best.fit.Score() : 0;
  }

  void MeasureDisagreement(const Rigid3d& start) {
    const IcpResult back = Register(target_.finest, source_.finest, start.Inverse(), options_.icp);
    const Rigid3d difference = verdict_.target_from_source * back.target_from_source;
    verdict_.disagreement_m = difference.translation.norm();
    verdict_.disagreement_rad = back.Succeeded() ? RotationAngle(difference.rotation) : M_PI;
  }

  ExpandedView source_, target_;
  const VerifyLoopOptions& options_;
  IcpOptions coarse_icp_;
  std::vector<CoarsePose> poses_;
  bool is_degenerate_ = false;  // coarse registration left directions free
  LoopVerdict verdict_;
};

}  // namespace

LoopVerdict VerifyLoop(const PlaceView& source, const PlaceView& target,
                       const VerifyLoopOptions& options,
                       const std::optional<Rigid3d>& target_from_source_prior) {
  Validate(options);
  LoopVerdict verdict;
  if (source.empty() || target.empty()) return verdict;
  LoopStarts starts = FindLoopStarts(source, target, options);
  verdict.matches = starts.matches;
  verdict.agreeing_features = starts.agreeing_features;
  std::vector<Rigid3d>& poses = starts.target_from_source;
  if (target_from_source_prior) poses.push_back(*target_from_source_prior);
  if (poses.empty()) {
    verdict.reason = LoopReason::kNoStart;
    return verdict;
  }
  return LoopVerifier(source, target, options).Verify(poses, verdict);
}

std::string ToString(LoopReason reason) {
  switch (reason) {
    case LoopReason::kNoView:
      return "no_view";
    case LoopReason::kNoStart:
      return "no_start";
    case LoopReason::kNotRegistered:
      return "not_registered";
    case LoopReason::kDegenerate:
      return "degenerate";
    case LoopReason::kLittleOverlap:
      return "little_overlap";
    case LoopReason::kPoorFit:
      return "poor_fit";
    case LoopReason::kFreeSpaceFilled:
      return "free_space_filled";
    case LoopReason::kLooksDifferent:
      return "looks_different";
    case LoopReason::kAmbiguous:
      return "ambiguous";
    case LoopReason::kInconsistent:
      return "inconsistent";
    case LoopReason::kAccepted:
      return "accepted";
  }
  return "unknown";
}

std::vector<LoopReason> LoopReasons() {
  std::vector<LoopReason> reasons;
  for (int i = 0; i <= static_cast<int>(LoopReason::kAccepted); ++i) {
    reasons.push_back(static_cast<LoopReason>(i));
  }
  return reasons;
}

}  // namespace surfit
