// SLAM over all sequences of a folder, each by a process of its own, and one table of the results.

#include <iomanip>
#include <iostream>
#include <sstream>

#include "apps/scan/batch.h"
#include "common/console.h"
#include "common/tool_main.h"
#include "common/workflow.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

struct Options {
  BatchOptions batch;
  WorkflowOptions workflow;

  Options() { batch.run.threads = 1; }  // of as many runs at a time as there are cores

  void Visit(OptionVisitor& v) {
    v.AddPart(batch, "batch", "which sequences are run, and how");
    v.AddPart(workflow, "workflow", "how the jobs are run");
  }
};

std::string Text(const std::optional<double>& number, double unit, int digits) {
  if (!number) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << *number / unit;
  return text.str();
}

std::string Text(const std::optional<int>& number) {
  return number ? std::to_string(*number) : "-";
}

void PrintTable(const std::vector<BatchRow>& rows) {
  std::vector<std::vector<std::string>> table = {
      {"sequence", "state", "frames", "tracked", "ATE mm", "RPE mm", "s", "MB"}};
  for (const BatchRow& row : rows) {
    table.push_back({row.sequence, row.state, Text(row.frames), Text(row.frames_tracked),
                     Text(row.ate_rmse_m, 1e-3, 1), Text(row.rpe_translation_rmse_m, 1e-3, 1),
                     Text(row.seconds, 1, 1), Text(row.peak_mb, 1, 0)});
  }
  std::cout << TextTable(table, 2);
}

int Run(const Options& options) {
  const std::string& folder = options.batch.output;
  const Workflow workflow(options.workflow, folder, "batch.smk");
  workflow.Lock();
  std::cout << PlanBatch(options.batch).size() << " sequences" << std::endl;
  ForgetRuns(folder, options.workflow.retry_failed);
  const bool ended = workflow.Run();
  const std::vector<BatchRow> rows = ReportBatch(folder);
  PrintTable(rows);
  std::cout << folder << "/report.html" << std::endl;
  bool has_failed = false;
  for (const BatchRow& row : rows) {
    if (row.state == "done") continue;
    std::cerr << "warning: " << row.sequence << ": " << row.error << '\n';
    has_failed |= row.state == "failed";
  }
  if (has_failed) std::cerr << "warning: --retry_failed does again what has failed" << std::endl;
  if (!ended) return kBadInput;
  return has_failed ? kAlgorithmFailed : kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "runs surfit_slam over all sequences of a folder, as jobs of Snakemake on this machine or a "
      "cluster, and puts trajectories' errors, times and what failed into one table. Flags of "
      "surfit_slam are for each of them. The same command goes on with a batch that was "
      "interrupted.",
      surfit::tools::Run);
}
