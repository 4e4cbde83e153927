#include <cmath>

#include "surfit/core/error.h"
#include "surfit/places/verify_loop.h"

namespace surfit {
namespace {

void RequireShare(const char* field, double value) {
  if (!(value >= 0 && value <= 1)) {
    throw InputError(Concat(field, " is ", value, ", must be from 0 to 1"));
  }
}

void RequirePositive(const char* field, double value) {
  if (!(value > 0)) throw InputError(Concat(field, " is ", value, ", must be positive"));
}

}  // namespace

IcpOptions VerifyLoopOptions::DefaultIcp() {
  IcpOptions icp;
  icp.residual = "symmetric_point_to_plane";
  icp.gates.max_distance_m = 0.05;
  icp.gates.max_normal_angle_rad = 0.5;
  icp.max_iterations = 20;
  icp.stop_at_rmse_increase = false;
  icp.error_model.photometric_weight = 0.01;
  return icp;
}

void VerifyLoopOptions::Validate() const {
  preprocess.Validate();
  icp.Validate();
  if (min_agreeing_features < 4) {
    throw InputError(
        Concat("min_agreeing_features is ", min_agreeing_features, ", must be at least 4"));
  }
  RequireShare("min_inlier_share", min_inlier_share);
  RequirePositive("max_rmse_m", max_rmse_m);
  RequireShare("min_overlap_share", min_overlap_share);
  RequireShare("max_free_space_share", max_free_space_share);
  RequireShare("min_value_correlation", min_value_correlation);
  RequireShare("min_detail_correlation", min_detail_correlation);
  RequireShare("min_lead", min_lead);
  RequirePositive("max_sigma_m", max_sigma_m);
  RequirePositive("max_sigma_rad", max_sigma_rad);
  RequirePositive("max_disagreement_m", max_disagreement_m);
  RequirePositive("max_disagreement_rad", max_disagreement_rad);
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
