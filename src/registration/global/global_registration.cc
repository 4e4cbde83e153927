#include "surfit/registration/global_registration.h"

#include <algorithm>
#include <cmath>

#include "core/named_values.h"
#include "registration/global/initial_pose_search.h"
#include "registration/global/register_from.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr std::size_t kRegistered = 3;  // maximum number of feature-based initial poses

constexpr NamedValue<GlobalRegistrationReason> kReasons[] = {
    {"no_view", GlobalRegistrationReason::kNoView},
    {"no_start", GlobalRegistrationReason::kNoStart},
    {"not_registered", GlobalRegistrationReason::kNotRegistered},
    {"degenerate", GlobalRegistrationReason::kDegenerate},
    {"little_overlap", GlobalRegistrationReason::kLittleOverlap},
    {"poor_fit", GlobalRegistrationReason::kPoorFit},
    {"free_space_violation", GlobalRegistrationReason::kFreeSpaceViolation},
    {"looks_different", GlobalRegistrationReason::kLooksDifferent},
    {"ambiguous", GlobalRegistrationReason::kAmbiguous},
    {"inconsistent", GlobalRegistrationReason::kInconsistent},
    {"accepted", GlobalRegistrationReason::kAccepted}};

GlobalRegistrationReason ReasonOf(const IcpResult& icp) {
  if (icp.Succeeded()) return GlobalRegistrationReason::kAccepted;
  if (icp.termination == Termination::kSingularSystem) return GlobalRegistrationReason::kDegenerate;
  if (icp.termination == Termination::kFreeSpaceViolation)
    return GlobalRegistrationReason::kFreeSpaceViolation;
  return GlobalRegistrationReason::kNotRegistered;
}

GlobalRegistrationResult RegisterFromIdentity(const ColoredView& source, const ColoredView& target,
                                              const IcpOptions& icp_options) {
  GlobalRegistrationResult verdict;
  verdict.icp = Register(source.pyramid, target.pyramid, verdict.start, icp_options);
  verdict.reason = ReasonOf(verdict.icp);
  verdict.target_from_source = verdict.icp.target_from_source;
  verdict.inlier_ratio = verdict.icp.inlier_ratio;
  verdict.rmse_m = verdict.icp.rmse_m;
  return verdict;
}

std::vector<Rigid3d> InitialPoses(const InitialPoseSearch& search, const MotionBound& bound) {
  std::vector<Rigid3d> starts;
  for (const CandidatePose& start : search.FindPoses(bound)) {
    if (starts.size() < kRegistered) starts.push_back(start.target_from_source);
  }
  return starts;
}

}  // namespace

std::string ToString(GlobalRegistrationReason reason) { return NameOf(reason, kReasons); }

std::vector<GlobalRegistrationReason> GlobalRegistrationReasons() {
  std::vector<GlobalRegistrationReason> reasons;
  for (const auto& reason : kReasons) reasons.push_back(reason.value);
  return reasons;
}

std::string ViolatedCriterion(const GlobalRegistrationResult& verdict, const FitCriteria& fit) {
  const auto at_least = [](const char* what, double value, double least) {
    return Concat(what, " is ", value, ", must be at least ", least);
  };
  const auto at_most = [](const char* what, double value, double most) {
    return Concat(what, " is ", value, ", must be at most ", most);
  };
  const auto both_at_most = [](const char* what, double m, double rad, double most_m,
                               double most_rad) {
    return Concat(what, " ", m, " m and ", rad, " rad, must be at most ", most_m, " m and ",
                  most_rad, " rad");
  };
  switch (verdict.reason) {
    case GlobalRegistrationReason::kDegenerate:
      if (verdict.sigma_m <= fit.max_sigma_m && verdict.sigma_rad <= fit.max_sigma_rad) return "";
      return both_at_most("largest standard deviations are", verdict.sigma_m, verdict.sigma_rad,
                          fit.max_sigma_m, fit.max_sigma_rad);
    case GlobalRegistrationReason::kLittleOverlap:
      return at_least("overlap share", verdict.overlap_ratio, fit.min_overlap_ratio);
    case GlobalRegistrationReason::kFreeSpaceViolation:
      return at_most("free-space share", verdict.free_space_violation_ratio,
                     fit.max_free_space_violation_ratio);
    case GlobalRegistrationReason::kLooksDifferent:
      return Concat("correlations of brightness and its detail are ", verdict.value_correlation,
                    " and ", verdict.detail_correlation, ", must be at least ",
                    fit.min_value_correlation, " and ", fit.min_detail_correlation);
    case GlobalRegistrationReason::kPoorFit:
      return Concat("RMSE is ", verdict.rmse_m, " m and inlier share ", verdict.inlier_ratio,
                    ", must be at most ", fit.max_rmse_m, " m and at least ", fit.min_inlier_ratio,
                    " of the overlap share");
    case GlobalRegistrationReason::kAmbiguous:
      return at_least("score margin over other poses", verdict.score_margin, fit.min_score_margin);
    case GlobalRegistrationReason::kInconsistent:
      return both_at_most("forward-backward disagreement is", verdict.disagreement_m,
                          verdict.disagreement_rad, fit.max_disagreement_m,
                          fit.max_disagreement_rad);
    default:
      return "";
  }
}

std::vector<std::string> InitializeMethods() { return {"identity", "features"}; }

FitCriteria InitializeOptions::FrameCriteria() {
  FitCriteria fit;
  fit.min_overlap_ratio = 0.15;
  fit.max_free_space_violation_ratio = 1;
  fit.needs_color = false;
  fit.min_value_correlation = 0.8;
  fit.min_detail_correlation = 0.05;
  fit.min_inlier_ratio = 0;
  fit.max_disagreement_m = fit.max_disagreement_rad = M_PI;
  return fit;
}

IcpOptions GlobalIcpOptions() {
  IcpOptions icp;
  icp.middle_levels = false;
  icp.min_coarse_step_px = 20;
  icp.gates.max_distance_m = 0.05;
  icp.gates.max_normal_angle_rad = 0.35;
  icp.gate_growth = 2.5;
  icp.kernel_growth = 4;
  icp.max_free_space_violation_ratio = 0.02;
  return icp;
}

IcpOptions IcpOptionsFromStart(const InitializeOptions& options, const IcpOptions& icp_options) {
  constexpr int kIterationGrowth = 10;
  constexpr double kFreeSpaceGrowth = 2;
  IcpOptions changed = icp_options;
  if (options.method == "identity") return changed;
  changed.max_iterations *= kIterationGrowth;
  changed.min_relative_rmse_change /= kIterationGrowth;
  changed.stop_at_rmse_increase = false;
  changed.max_free_space_violation_ratio =
      std::min(1., kFreeSpaceGrowth * icp_options.max_free_space_violation_ratio);
  return changed;
}

GlobalRegistrationResult RegisterGlobally(const ColoredView& source, const ColoredView& target,
                                          const InitializeOptions& options,
                                          const IcpOptions& icp_options, const MotionBound& bound) {
  Validate(options);
  if (options.method == "identity") return RegisterFromIdentity(source, target, icp_options);
  const InitialPoseSearch search(source, target, icp_options.error_model);
  const IcpOptions icp = IcpOptionsFromStart(options, icp_options);
  const GlobalView from = {source.pyramid, source.pyramid, search.SourceLevel(),
                           !source.color.empty()};
  const GlobalView to = {target.pyramid, target.pyramid, search.TargetLevel(),
                         !target.color.empty()};
  return RegisterFrom(InitialPoses(search, bound), from, to, {icp, icp, options.fit});
}

}  // namespace surfit
