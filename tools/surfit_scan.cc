// A scan of any length: plans its jobs and has Snakemake run them.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "common/tool_main.h"
#include "common/workflow.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

struct ScanOptions {
  ScanPlanOptions plan;
  WorkflowOptions workflow;

  void Visit(OptionVisitor& v) {
    v.AddPart(plan, "plan", "how the sequence is cut into fragments");
    v.AddPart(workflow, "workflow", "how the jobs are run");
  }
};

int Run(const ScanOptions& options) {
  const std::string& scan = options.plan.run.output;
  const Workflow workflow(options.workflow, scan, "Snakefile");
  workflow.Lock();
  const ScanPlan plan = PlanScan(options.plan);
  std::cout << plan.fragments.size() << " fragments" << std::endl;
  ForgetJobs(scan, options.workflow.retry_failed);
  if (!workflow.Run()) return kBadInput;
  const ScanSummary summary = ReadScanSummary(scan);
  std::cout << summary.frames << " of " << summary.frames_total << " frames have a pose";
  if (summary.ate_rmse_m) std::cout << ", ATE " << 1000 * *summary.ate_rmse_m << " mm";
  std::cout << "; " << summary.tiles << " tiles; " << scan << "/report.html" << std::endl;
  for (const ScannedRecording& recording : summary.recordings) {
    if (recording.frames > 0) continue;
    std::cerr << "warning: " << recording.sequence << ": no frame has a pose\n";
  }
  for (const std::string& failed : summary.failed) std::cerr << "warning: " << failed << '\n';
  if (!summary.failed.empty()) {
    std::cerr << "warning: --retry_failed does again what has failed" << std::endl;
  }
  return summary.frames == 0 || 2 * summary.frames < summary.frames_total ? kAlgorithmFailed
                                                                          : kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "turns recordings of one place, of any length, into trajectories and a map in tiles: cuts "
      "them into fragments, and has Snakemake run the jobs on this machine or a cluster. The same "
      "command "
      "goes on with a scan that was interrupted.",
      surfit::tools::Run);
}
