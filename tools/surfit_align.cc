// Registers two frames of a sequence and shows how well they fit.

#include <gflags/gflags.h>

#include <cstdio>

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
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time");

namespace surfit::tools {
namespace {

void PrintIterations(const IcpResult& icp) {
  int level = -1, count = 0;
  for (const IcpIteration& iteration : icp.iterations) {
    if (iteration.level != level) {
      std::printf("level %d\n", iteration.level);
      level = iteration.level;
      count = 0;
    }
    std::printf("iter %d: avg loss = %.4e, inlier count = %d\n", count++, iteration.average_loss,
                iteration.inlier_count);
  }
}

void PrintResult(const AlignRunResult& result) {
  const IcpResult& icp = result.icp;
  std::printf(
      "%s: rmse %.4f m, inlier share %.3f, free-space share %.3f, smallest eigenvalue %.2e\n",
      ToString(icp.termination).c_str(), icp.rmse_m, icp.inlier_share, icp.free_space_share,
      icp.eigenvalues[0]);
  const Eigen::Matrix4d pose = icp.target_from_source.Matrix();
  std::printf("target_from_source =\n");
  for (int row = 0; row < 4; ++row) {
    std::printf("  %12.8f %12.8f %12.8f %12.8f\n", pose(row, 0), pose(row, 1), pose(row, 2),
                pose(row, 3));
  }
  if (!result.final_error) {
    std::printf("pose error unknown: no ground truth for these frames\n");
    return;
  }
  std::printf("pose error: %.4f m, %.3f deg (before: %.4f m, %.3f deg)\n",
              result.final_error->translation_m, result.final_error->rotation_deg,
              result.initial_error->translation_m, result.initial_error->rotation_deg);
}

// What an unsuccessful registration lacks: value and constraint.
std::string Failure(const IcpResult& icp, const IcpOptions& options) {
  switch (icp.termination) {
    case Termination::kTooFewInliers:
      return Concat("inlier share is ", icp.inlier_share, ", pairs must be at least min_inliers (",
                    options.min_inliers, ") and a share of ", options.min_inlier_share);
    case Termination::kSingularSystem:
      return Concat("smallest eigenvalue is ", icp.eigenvalues[0], ", must be above ",
                    options.min_eigenvalue);
    case Termination::kFreeSpaceFilled:
      return Concat("free-space share is ", icp.free_space_share,
                    ", must be at most max_free_space_share (", options.max_free_space_share, ")");
    case Termination::kConverged:
    case Termination::kRmseIncreased:
    case Termination::kMaxIterations:
      break;
  }
  return "";
}

int Run() {
  AlignRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.source = FLAGS_source;
  options.target = FLAGS_target;
  options.output = FLAGS_output;
  options.threads = FLAGS_threads;
  options.preprocess = PreprocessOptionsFromFlags();
  options.icp = IcpOptionsFromFlags(surfit::AlignRunOptions::DefaultIcp());
  SetSolverFromFlags(&options.icp);
  const AlignRunResult result = RunAlign(options);
  PrintIterations(result.icp);
  PrintResult(result);
  std::printf("pictures: %s/before.png, %s/after.png\n", FLAGS_output.c_str(),
              FLAGS_output.c_str());
  if (result.icp.Succeeded()) return kDone;
  std::fprintf(stderr, "failed: %s: %s\n", ToString(result.icp.termination).c_str(),
               Failure(result.icp, options.icp).c_str());
  return kAlgorithmFailed;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::SetIcpFlagDefaults(surfit::AlignRunOptions::DefaultIcp());
  return surfit::tools::ToolMain(argc, argv, "registers two frames of an RGB-D sequence",
                                 surfit::tools::Run);
}
