#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace surfit {

class OptionVisitor;

struct ReportOptions {
  // output folders of RunSlam() or RunRefinement(), at least one, shown side by side
  std::vector<std::string> runs;
  std::string output;  // path of the HTML file

  void Visit(OptionVisitor& visitor);
};

// Number of surfels of a run, and of those in the report.
struct ReportedMap {
  std::string run;
  std::size_t points = 0;
  std::size_t shown_points = 0;
};

// Writes a self-contained HTML file that needs no network. The page shows:
// - maps, trajectories, loop closures and pose graphs in 3D
// - errors against ground truth, and statistics of every frame
// - input images next to model views
// - map differences, calibrations, summaries and options
//
// Reads the folders of all runs. Throws InputError for invalid options, and with the path of a
// missing, invalid or unwritable file. Returns one entry per run, in the order of the options.
std::vector<ReportedMap> WriteReport(const ReportOptions& options);

}  // namespace surfit
