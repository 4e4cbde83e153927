// Cuts a recording into fragments that can be processed apart from each other.

#include <iostream>

#include "apps/scan/scan_plan.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const ScanPlanOptions& options) {
  const ScanPlan plan = PlanScan(options);
  for (const ScanFragment& fragment : plan.fragments) {
    std::cout << fragment.name << ": " << plan.recordings[fragment.recording].path << ", frames "
              << fragment.first << " to " << fragment.last << '\n';
  }
  std::cout << options.run.output << "/plan.json: " << plan.fragments.size() << " fragments"
            << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "cuts RGB-D sequences of one place into fragments that overlap, each to be tracked by a "
      "process of its "
      "own (surfit_slam --flagfile=fragments/NAME.flags). No image is copied.",
      surfit::tools::Run);
}
