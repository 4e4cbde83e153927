// Finds which fragments of a scan may have seen the same places.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const CandidatesOptions& options) {
  const CandidatesResult result = FindCandidates(options);
  std::cout << result.fragments << " fragments (" << result.missing << " missing), "
            << result.keyframes << " keyframes (" << result.looked_up
            << " looked up): " << result.pairs << " pairs of fragments look alike" << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "looks up the keyframes of all fragments of a scan in one index, and writes which pairs of "
      "fragments may have seen the same place.",
      surfit::tools::Run);
}
