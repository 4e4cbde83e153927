// Runs SLAM on all sequences of a folder, one process per sequence, and prints a table of the
// results.

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

  Options() { batch.run.threads = 1; }  // several runs share the cores

  void Visit(OptionVisitor& v) {
    v.AddPart(batch, "batch", "sequences and their runs");
    v.AddPart(workflow, "workflow", "jobs");
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
  DeleteStaleRunReceipts(folder, options.workflow.retry_failed);
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
  if (has_failed) std::cerr << "warning: set --retry_failed to repeat the failed runs" << std::endl;
  if (!ended) return kBadInput;
  return has_failed ? kAlgorithmFailed : kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "runs surfit_slam on all sequences of a folder, as Snakemake jobs on this machine or a "
      "cluster, and writes a table of trajectory errors, times and failures. Flags of surfit_slam "
      "apply to all runs. The same command continues an interrupted batch.",
      surfit::tools::Run);
}
