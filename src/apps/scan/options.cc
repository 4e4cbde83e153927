// The options of this module.
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

}  // namespace

void ScanPlanOptions::Visit(OptionVisitor& v) {
  v.Group("sequence");
  v.Add(sequences,
        SharedOption("sequence", InField("sequences"), Required(), Repeatable(), Everyday()));
  v.AddPart(
      run, "run", "how each fragment is tracked", OptionalPart(),
      WithoutFlags({"sequence", "loop_closure", "calibrate", "refine", "final_map", "pictures",
                    "report", "keep_places", "session", "continue", "localize", "trace",
                    "dump_failures", "offered_fps", "real_time", "poses", "initial_pose"}));
  v.Group("fragments");
  v.Add(fragment_frames, "fragment_frames", "frames of a fragment at most", AtLeast(2), AsFlag(),
        Everyday());
  v.Add(overlap_frames, "overlap_frames", "frames that a fragment shares with the next", AtLeast(1),
        AsFlag());
  v.Add(camera_frames, "camera_frames",
        "frames at the beginning of a sequence by which its depth camera is calibrated", AtLeast(0),
        ZeroIs("it is as given"), AsFlag());
  v.Add(tile_m, "tile_m", "side of a tile of the map, a cube", AtLeast(0.5), AsFlag());
  v.Add(pictures, SharedOption("pictures"));
  v.Check([this] {
    ThrowIf(run.output.empty(), "output is missing, must be set");
    const std::set<std::string> different(sequences.begin(), sequences.end());
    ThrowIf(different.size() < sequences.size() || different.count("") > 0,
            "sequence has one twice or without a name, must have different ones");
    if (overlap_frames < fragment_frames) return;
    throw InputError("overlap_frames is ", overlap_frames, ", must be below fragment_frames, ",
                     fragment_frames);
  });
}

void CandidatesOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Group("places");
  v.Add(min_gap, "min_gap", "frames between two keyframes that are looked at", AtLeast(1),
        AsFlag());
  v.Add(max_alike, "max_alike", "keyframes of other fragments that look most alike", AtLeast(1),
        AsFlag());
  v.Add(max_index_bytes, "max_index_bytes",
        "memory for the index of all places; beyond, only each n-th keyframe is looked up",
        AtLeast(1), AsFlag());
}

void LinkOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
  v.Add(candidates, "candidates", "file of a pair of fragments, written by --step=candidates",
        Required(), AsFlag(), Everyday());
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
  v.Add(tile, "tile", "its name in graph/tiles.json", Required(), AsFlag(), Everyday());
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(margin_m, "margin_m", "around the tile is fused as well", Positive(), AsFlag());
  v.Add(threads, SharedOption("threads", Everyday()));
}

void ScanReportOptions::Visit(OptionVisitor& v) {
  v.Group("run");
  v.Add(scan, Scan());
}

}  // namespace surfit
