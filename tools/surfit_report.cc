// Writes one page about runs of surfit_slam, side by side.

#include <gflags/gflags.h>

#include <string>
#include <vector>

#include "common/report.h"
#include "common/tool_main.h"

namespace {

const surfit::ReportOptions kReport;

// gflags keeps a flag's last value only, but shows each one to its validator.
std::vector<std::string> g_runs;

bool KeepRun(const char* /*flag*/, const std::string& value) {
  if (!value.empty()) g_runs.push_back(value);
  return true;
}

}  // namespace

DEFINE_string(run, "", "output folder of surfit_slam; several --run stand side by side");
DEFINE_validator(run, &KeepRun);
DEFINE_string(output, kReport.output, "the page; if empty, report.html in the first run's folder");
DEFINE_int32(max_points, kReport.max_points,
             "surfels of all runs together that the page holds; of larger maps evenly spread ones");

namespace surfit::tools {
namespace {

int Run() {
  RequireFlag("run", FLAGS_run);
  ReportOptions options;
  options.runs = g_runs;
  options.output = FLAGS_output.empty() ? g_runs.front() + "/report.html" : FLAGS_output;
  options.max_points = FLAGS_max_points;
  WriteAndPrintReport(options);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "writes one HTML page, to be opened in a browser without network, about one or more runs of "
      "surfit_slam: maps and trajectories in 3D, errors, figures of every frame, views, options. "
      "Pictures of the input beside the model's views come from runs with --report.",
      surfit::tools::Run);
}
