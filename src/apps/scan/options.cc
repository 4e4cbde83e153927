#include "surfit/core/options.h"

#include <set>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

Option Scan() {
  return Option("scan", "folder of the scan, with plan.json", Required(), Everyday());
}

// Work of one job.
Option Part(const std::string& field) {
  return Option(field,
                "link: file with the candidates of two fragments, written by --step=candidates; "
                "tile: name of the tile in graph/tiles.json",
                Required(), AsFlag("part"), Everyday());
}

}  // namespace

void ScanPlanOptions::Visit(OptionVisitor& v) {
  v.Group("sequence");
  v.Add(sequences,
        SharedOption("sequence", InField("sequences"), Required(), Repeatable(), Everyday()));
  v.AddPart(
      run, "run", "options of the fragment runs", OptionalPart(),
      WithoutFlags({"sequence", "loop_closure", "new_map_after", "calibrate", "refine", "final_map",
                    "pictures", "report", "keep_places", "session", "continue", "localize", "trace",
                    "dump_failures", "offered_fps", "poses", "initial_pose"}));
  v.Group("fragments");
  v.Add(fragment_frames, "fragment_frames", "maximum number of frames of a fragment", AtLeast(2));
  v.Add(overlap_frames, "overlap_frames", "number of frames shared by consecutive fragments",
        AtLeast(1));
  v.Add(camera_frames, "camera_frames",
        "number of frames at the start of a sequence for the calibration of the depth camera",
        AtLeast(0), ZeroIs("no calibration"));
  v.Add(tile_m, "tile_m", "edge length of a map tile", AtLeast(0.5), AsFlag());
  v.Add(pictures, SharedOption("pictures"));
  v.Check([this] {
    ThrowIf(run.output.empty(), "output is missing, must be set");
    const std::set<std::string> different(sequences.begin(), sequences.end());
    ThrowIf(different.size() < sequences.size() || different.count("") > 0,
            "sequence contains a duplicate or an empty path, must be different paths");
    if (overlap_frames < fragment_frames) return;
    throw InputError("overlap_frames is ", overlap_frames, ", must be below fragment_frames, ",
                     fragment_frames);
  });
}

void CandidatesOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(output, SharedOption("output", Required(), Everyday()));
}

void LinkOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(candidates, Part("candidates"));
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
}

void GraphOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(output, SharedOption("output", Required(), Everyday()));
}

void TileOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(tile, Part("tile"));
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(threads, SharedOption("threads", Everyday()));
}

void ScanReportOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
}

}  // namespace surfit
