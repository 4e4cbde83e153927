// Registers two frames of a sequence and shows how well they fit.

#include <gflags/gflags.h>

#include <cstdio>

#include "common/icp_report.h"
#include "common/sequence_flags.h"
#include "common/slam_flags.h"
#include "common/solver_flags.h"
#include "common/tool_main.h"
#include "surfit/run/align_run.h"

namespace {

const surfit::AlignRunOptions kRun;

}  // namespace

DEFINE_int32(source, kRun.source, "index of the frame to be moved");
DEFINE_int32(target, kRun.target, "index of the frame to be met");
DEFINE_string(output, kRun.output, "folder for clouds and pictures; made if missing");
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time");

namespace surfit::tools {
namespace {

void PrintResult(const AlignRunResult& result) {
  const IcpResult& icp = result.icp;
  std::printf(
      "%s: rmse %.4f m, inlier share %.3f, free-space share %.3f, smallest eigenvalue %.2e\n",
      ToString(icp.termination).c_str(), icp.rmse_m, icp.inlier_share, icp.free_space_share,
      icp.eigenvalues[0]);
  PrintPose(icp);
  if (!result.final_error) {
    std::printf("pose error unknown: no ground truth for these frames\n");
    return;
  }
  std::printf("pose error: %.4f m, %.3f deg (before: %.4f m, %.3f deg)\n",
              result.final_error->translation_m, result.final_error->rotation_deg,
              result.initial_error->translation_m, result.initial_error->rotation_deg);
}

int Run() {
  AlignRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.source = FLAGS_source;
  options.target = FLAGS_target;
  options.output = FLAGS_output;
  options.threads = FLAGS_threads;
  options.preprocess = PreprocessOptionsFromFlags();
  options.icp = FrameIcpOptionsFromFlags(surfit::AlignRunOptions::DefaultIcp());
  SetSolverFromFlags(&options.icp);
  const AlignRunResult result = RunAlign(options);
  PrintIterations(result.icp);
  PrintResult(result);
  std::printf("pictures: %s/before.png, %s/after.png\n", FLAGS_output.c_str(),
              FLAGS_output.c_str());
  return PrintFailure(result.icp, options.icp);
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::SetIcpFlagDefaults(surfit::AlignRunOptions::DefaultIcp());
  return surfit::tools::ToolMain(argc, argv, "registers two frames of an RGB-D sequence",
                                 surfit::tools::Run);
}
