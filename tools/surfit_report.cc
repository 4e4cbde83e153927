// Writes one page about runs of surfit_slam, side by side.

#include "common/outcomes.h"
#include "common/tool_main.h"

int main(int argc, char** argv) {
  surfit::ReportOptions options;
  return surfit::tools::ToolMain(
      argc, argv,
      "writes one HTML page, to be opened in a browser without network, about one or more runs of "
      "surfit_slam: maps and trajectories in 3D, errors, figures of every frame, views, options. "
      "Pictures of the input beside the model's views come from runs with --report.",
      surfit::TableOf(&options),
      [&] {
        surfit::tools::WriteAndPrintReport(options);
        return surfit::tools::kDone;
      },
      [&] {
        surfit::tools::RequireFlag("run", options.runs.empty() ? "" : options.runs.front());
        options.output = options.runs.front() + "/report.html";
      });
}
