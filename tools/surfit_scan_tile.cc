// Fuses one tile of the map of a scan.

#include <iostream>

#include "apps/scan/scan_jobs.h"
#include "common/console.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

int Run(const TileOptions& options) {
  ProgressLine line;
  const std::size_t points = FuseTile(options, CatchInterruptions(), [&](int frames) {
    line.Show(Concat("frame ", frames), /*last=*/false);
  });
  std::cout << options.output << ": " << points << " surfels" << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "fuses what the frames of a scan see of one tile of the map, along the final poses.",
      surfit::tools::Run);
}
