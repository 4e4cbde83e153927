// Registers two frames of a sequence and shows how well they fit.

#include <gflags/gflags.h>

#include <cstdio>

#include "common/icp_report.h"
#include "common/sequence_flags.h"
#include "common/slam_flags.h"
#include "common/solver_flags.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/align_run.h"

namespace {

const surfit::AlignRunOptions kRun;

}  // namespace

DEFINE_int32(source, kRun.source, "index of the frame to be moved");
DEFINE_int32(target, kRun.target, "index of the frame to be met");
DEFINE_string(output, kRun.output, "folder for clouds and pictures; made if missing");
DEFINE_string(initialize, kRun.initialize.method,
              "where registration starts: identity, so3 (the rotation that makes small images most "
              "alike) or features (poses that image features agree on, and poses that shapes and "
              "brightness find from many rotations); all but identity are verified");
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time");

namespace surfit::tools {
namespace {

void PrintResult(const AlignRunResult& result) {
  const IcpResult& icp = result.registration.icp;
  std::printf(
      "%s: rmse %.4f m, inlier share %.3f, free-space share %.3f, smallest eigenvalue %.2e\n",
      ToString(icp.termination).c_str(), icp.rmse_m, icp.inlier_share, icp.free_space_share,
      icp.eigenvalues[0]);
  if (FLAGS_initialize != "identity") {
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

int Run() {
  AlignRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.source = FLAGS_source;
  options.target = FLAGS_target;
  options.output = FLAGS_output;
  options.initialize.method = FLAGS_initialize;
  options.threads = FLAGS_threads;
  options.preprocess = PreprocessOptionsFromFlags();
  options.icp = FrameIcpOptionsFromFlags(surfit::FarIcpOptions());
  SetSolverFromFlags(&options.icp);
  const AlignRunResult result = RunAlign(options);
  const IcpResult& icp = result.registration.icp;
  PrintIterations(icp);
  PrintResult(result);
  std::printf("pictures: %s/before.png, %s/after.png\n", FLAGS_output.c_str(),
              FLAGS_output.c_str());
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
  surfit::tools::SetIcpFlagDefaults(surfit::FarIcpOptions());
  return surfit::tools::ToolMain(argc, argv, "registers two frames of an RGB-D sequence",
                                 surfit::tools::Run);
}
