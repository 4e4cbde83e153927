// Registers two frames of a sequence and shows how well they fit.

#include <cstdio>

#include "common/icp_report.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/register_run.h"

namespace surfit::tools {
namespace {

void PrintResult(const AlignRunResult& result, bool verified) {
  const IcpResult& icp = result.registration.icp;
  std::printf(
      "%s: rmse %.4f m, inlier share %.3f, free-space share %.3f, smallest eigenvalue %.2e\n",
      ToString(icp.termination).c_str(), icp.rmse_m, icp.inlier_share, icp.free_space_share,
      icp.eigenvalues[0]);
  if (verified) {
    std::printf(
        "verified by: overlap share %.3f, correlation of brightness %.3f, of its detail %.3f, lead "
        "over other poses %.3f\n",
        result.registration.overlap_share, result.registration.value_correlation,
        result.registration.detail_correlation, result.registration.lead);
  }
  PrintPose(icp);
  if (!result.final_error) {
    std::printf("pose error unknown: no ground truth for these frames\n");
    return;
  }
  std::printf("pose error: %.4f m, %.3f deg (before: %.4f m, %.3f deg)\n",
              result.final_error->translation_m, result.final_error->rotation_deg,
              result.initial_error->translation_m, result.initial_error->rotation_deg);
}

// What a registration that succeeded lacks to be believed.
std::string Doubt(const InitializedIcpResult& result, const InitializeOptions& options) {
  if (result.overlap_share < options.min_overlap_share) {
    return Concat("overlap share is ", result.overlap_share, ", must be at least ",
                  options.min_overlap_share);
  }
  if (result.lead < options.min_lead) {
    return Concat("lead over other poses is ", result.lead, ", must be at least ",
                  options.min_lead);
  }
  return Concat("correlations of brightness and its detail are ", result.value_correlation, " and ",
                result.detail_correlation, ", must be at least ", options.min_value_correlation,
                " and ", options.min_detail_correlation);
}

int Run(const AlignRunOptions& options) {
  const AlignRunResult result = RunAlign(options);
  const IcpResult& icp = result.registration.icp;
  PrintIterations(icp);
  PrintResult(result, options.initialize.method != "identity");
  std::printf("pictures: %s/before.png, %s/after.png\n", options.output.c_str(),
              options.output.c_str());
  if (icp.termination != Termination::kNotVerified) {
    return PrintFailure(icp, IcpOptionsFromStart(options.initialize, options.icp));
  }
  std::fprintf(stderr, "failed: not_verified: %s\n",
               Doubt(result.registration, options.initialize).c_str());
  return kAlgorithmFailed;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::AlignRunOptions options;
  return surfit::tools::ToolMain(argc, argv, "registers two frames of an RGB-D sequence",
                                 surfit::TableOf(&options),
                                 [&] { return surfit::tools::Run(options); });
}
