#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace surfit {

class OptionVisitor;

// Which runs a report shows.
struct ReportOptions {
  std::vector<std::string> runs;  // output folders of RunSlam(), to be shown side by side
  std::string output;             // the HTML file to write
  // Surfels of all runs together that the page holds: of larger maps evenly spread ones.
  int max_points = 500000;

  void Visit(OptionVisitor& visitor);
};

// What a report holds of one run's map.
struct ReportedMap {
  std::string run;
  std::size_t points = 0;        // surfels of the map
  std::size_t shown_points = 0;  // of these, in the page
};

// Writes one HTML file that needs no other and no network: maps, trajectories, loops and pose
// graphs in 3D, errors against ground truth, figures of every frame, views of the input beside the
// model's, how maps of equal times differ, calibrations, summaries and options. Reads map.ply,
// frames.csv, summary.json, poses.json, loops.csv, thumbnails/ and views/ of each run, or what
// RunRefinement() has written. It holds three.js and Chart.js. Throws InputError naming the file
// that is missing, is broken or cannot be written.
std::vector<ReportedMap> WriteReport(const ReportOptions& options);

}  // namespace surfit
