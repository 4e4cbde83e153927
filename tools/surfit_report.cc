// Writes a page that shows one or more runs of surfit_slam.

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
      "writes one HTML page about one or more runs of surfit_slam, which a browser can open "
      "without "
      "network: maps and trajectories in 3D, errors, figures per frame, views, options. Several "
      "--run are shown side by side. The default of --output is report.html in the folder of the "
      "first run. Input images next to the model views require runs with --report.",
      surfit::tools::Run, surfit::tools::SetOutput);
}
