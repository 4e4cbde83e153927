// Says what came of a scan.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const ScanReportOptions& options) {
  const ScanSummary summary = ReportScan(options);
  std::cout << options.scan << "/report.html: " << summary.frames << " of " << summary.frames_total
            << " frames have a pose, " << summary.failed.size() << " jobs failed" << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "puts the results of a scan's jobs together: summary.json, trajectory.txt, pictures and "
      "report.html.",
      surfit::tools::Run);
}
