#include "surfit/registration/initialize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "registration/start_search.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr std::size_t kRegistered = 3;  // of the poses found, the best
// Results nearer to each other than this are one.
constexpr double kSameDistanceM = 0.03;
constexpr double kSameAngleRad = 0.02;

struct Candidate {
  InitializedIcpResult result;
  double score = 0;
};

bool AreSame(const Rigid3d& a, const Rigid3d& b) {
  return (a.translation - b.translation).norm() < kSameDistanceM &&
         RotationAngle(a.rotation.conjugate() * b.rotation) < kSameAngleRad;
}

Candidate RegisterFrom(const Rigid3d& start, const ColoredView& source, const ColoredView& target,
                       const StartSearch& search, const IcpOptions& icp_options) {
  Candidate candidate;
  InitializedIcpResult& result = candidate.result;
  result.icp = Register(source.pyramid, target.pyramid, start, icp_options);
  result.start = start;
  const ViewFit fit = search.Measure(result.icp.target_from_source);
  result.overlap_share = fit.overlap_share;
  result.value_correlation = fit.value_correlation;
  result.detail_correlation = fit.detail_correlation;
  candidate.score = fit.Score();
  return candidate;
}

// The candidate with the highest score, those that failed last, and its lead over the others.
InitializedIcpResult Best(std::vector<Candidate> candidates) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    const bool a_succeeded = a.result.icp.Succeeded(), b_succeeded = b.result.icp.Succeeded();
    return a_succeeded != b_succeeded ? a_succeeded : a.score > b.score;
  });
  Candidate& best = candidates.front();
  double rival_score = 0;
  for (const Candidate& other : candidates) {
    if (AreSame(best.result.icp.target_from_source, other.result.icp.target_from_source)) continue;
    rival_score = std::max(rival_score, other.score);
  }
  // The score is the root of the overlap times what a pixel tells.
  if (best.result.overlap_share > 0) {
    best.result.lead = (best.score - rival_score) / std::sqrt(best.result.overlap_share);
  }
  return std::move(best.result);
}

bool IsVerified(const InitializedIcpResult& result, const InitializeOptions& options,
                bool has_color) {
  if (result.overlap_share < options.min_overlap_share) return false;
  if (result.lead < options.min_lead) return false;
  return !has_color || (result.value_correlation >= options.min_value_correlation &&
                        result.detail_correlation >= options.min_detail_correlation);
}

}  // namespace

std::vector<std::string> InitializeMethods() { return {"identity", "so3", "features"}; }

IcpOptions FarIcpOptions() {
  IcpOptions icp;
  icp.middle_levels = false;
  icp.min_coarse_step_px = 20;
  icp.gates.max_distance_m = 0.05;
  icp.gates.max_normal_angle_rad = 0.35;
  icp.gate_growth = 2.5;
  icp.kernel_growth = 4;
  icp.max_free_space_share = 0.02;
  return icp;
}

IcpOptions IcpOptionsFromStart(const InitializeOptions& options, const IcpOptions& icp_options) {
  IcpOptions changed = icp_options;
  if (options.method == "identity") return changed;
  changed.max_iterations *= options.iteration_growth;
  changed.min_relative_rmse_change /= options.iteration_growth;
  changed.stop_at_rmse_increase = false;
  changed.max_free_space_share =
      std::min(1., options.free_space_growth * icp_options.max_free_space_share);
  return changed;
}

InitializedIcpResult InitializeAndRegister(const ColoredView& source, const ColoredView& target,
                                           const InitializeOptions& options,
                                           const IcpOptions& icp_options) {
  Validate(options);
  if (options.method == "identity") {
    InitializedIcpResult result;
    result.icp = Register(source.pyramid, target.pyramid, result.start, icp_options);
    return result;
  }
  const StartSearch search(source, target, icp_options.error_model);
  const IcpOptions far_options = IcpOptionsFromStart(options, icp_options);
  std::vector<Candidate> candidates;
  if (options.method == "so3") {
    candidates.push_back(RegisterFrom(search.FindRotation(), source, target, search, far_options));
  } else {
    for (const StartPose& start : search.FindPoses()) {
      if (candidates.size() == kRegistered) break;
      candidates.push_back(
          RegisterFrom(start.target_from_source, source, target, search, far_options));
    }
  }
  InitializedIcpResult result = Best(std::move(candidates));
  const bool has_color = !source.color.empty() && !target.color.empty();
  if (result.icp.Succeeded() && !IsVerified(result, options, has_color)) {
    result.icp.termination = Termination::kNotVerified;
  }
  return result;
}

}  // namespace surfit
