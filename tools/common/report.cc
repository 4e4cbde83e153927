#include "common/report.h"

#include <cstdio>

namespace surfit::tools {

void WriteAndPrintReport(const ReportOptions& options) {
  for (const ReportedMap& map : WriteReport(options)) {
    std::printf("%s: %zu of %zu surfels in the report\n", map.run.c_str(), map.shown_points,
                map.points);
  }
  std::printf("report: %s\n", options.output.c_str());
}

}  // namespace surfit::tools
