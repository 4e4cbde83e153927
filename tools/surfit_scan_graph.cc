// Makes one trajectory of the fragments of a scan.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

int Run(const GraphOptions& options) {
  const GraphResult result = BuildScanGraph(options);
  std::cout << result.fragments << " fragments (" << result.missing << " missing, " << result.apart
            << " apart), " << result.keyframes << " keyframes, " << result.frames << " frames; "
            << result.links_accepted << " links, " << result.links_left_out << " left out; "
            << result.tiles << " tiles";
  if (result.ate_rmse_m) std::cout << "; ATE " << 1000 * *result.ate_rmse_m << " mm";
  std::cout << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "solves the pose graph of all fragments of a scan, and writes the poses of all frames and "
      "the tiles of the map that they see.",
      surfit::tools::Run);
}
