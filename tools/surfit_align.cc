// Registers two frames of a sequence and prints the quality of the result.

#include <cstdio>

#include "apps/solvers/register_run.h"
#include "common/outcomes.h"
#include "common/settings_text.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

struct Options {
  AlignRunOptions align;

  void Visit(OptionVisitor& v) {
    v.AddPart(align, "align", "alignment");
    v.Group("sequence");
    PairText pair(Option("source_frame", "", AtLeast(0)), &align.source,
                  Option("target_frame", "", AtLeast(0)), &align.target);
    v.AddText(pair, Option("pair",
                           "SOURCE,TARGET: index of the source frame, which is moved, and of the "
                           "target frame",
                           Everyday()));
  }
};

void PrintResult(const AlignRunResult& result, bool verified) {
  const IcpResult& icp = result.registration.icp;
  std::printf(
      "%s: rmse %.4f m, inlier share %.3f, free-space share %.3f, smallest eigenvalue %.2e\n",
      ToString(icp.termination).c_str(), icp.rmse_m, icp.inlier_ratio,
      icp.free_space_violation_ratio, icp.eigenvalues[0]);
  if (verified) {
    std::printf(
        "verification: overlap share %.3f, brightness correlation %.3f, detail correlation %.3f, "
        "score margin %.3f\n",
        result.registration.overlap_ratio, result.registration.value_correlation,
        result.registration.detail_correlation, result.registration.score_margin);
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

int Run(const Options& given) {
  const AlignRunOptions& options = given.align;
  const AlignRunResult result = RunAlign(options);
  const IcpResult& icp = result.registration.icp;
  PrintIterations(icp);
  PrintResult(result, options.initialize.method != "identity");
  std::printf("pictures: %s/before.png, %s/after.png\n", options.output.c_str(),
              options.output.c_str());
  if (!icp.Succeeded()) {
    return PrintFailure(icp, IcpOptionsFromStart(options.initialize, options.icp));
  }
  if (result.registration.accepted()) return kDone;
  std::fprintf(stderr, "failed: %s: %s\n", ToString(result.registration.reason).c_str(),
               ViolatedCriterion(result.registration, options.initialize.fit).c_str());
  return kAlgorithmFailed;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv, "registers two frames of an RGB-D sequence",
                                 surfit::tools::Run);
}
