// Writes one page about runs of surfit_slam, side by side.

#include "common/outcomes.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const ReportOptions& options) {
  WriteAndPrintReport(options);
  return kDone;
}

void SetOutput(ReportOptions* options) {
  RequireFlag("run", options->runs.empty() ? "" : options->runs.front());
  options->output = options->runs.front() + "/report.html";
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "writes one HTML page, to be opened in a browser without network, about one or more runs of "
      "surfit_slam: maps and trajectories in 3D, errors, figures of every frame, views, options. "
      "Several --run stand side by side. The default of --output is report.html in the folder of "
      "the first run. Pictures of the input beside the model's views come from runs with --report.",
      surfit::tools::Run, surfit::tools::SetOutput);
}
