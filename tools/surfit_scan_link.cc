// Joins two fragments of a scan.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const LinkOptions& options) {
  int accepted = 0;
  const std::vector<ScanLink> links = LinkFragments(options);
  for (const ScanLink& link : links) accepted += link.verdict.accepted();
  std::cout << accepted << " of " << links.size() << " pairs of keyframes show the same place"
            << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "verifies the pairs of keyframes by which two fragments of a scan may be joined, each "
      "densely and both ways.",
      surfit::tools::Run);
}
