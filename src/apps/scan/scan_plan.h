#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

class OptionVisitor;

// How recordings of one place are cut into fragments that are tracked apart from each other.
struct ScanPlanOptions {
  std::vector<std::string> sequences;  // of one place: at least one
  // Of each fragment; its output is the scan's folder. Its sequence says how all are read.
  SlamRunOptions run;
  int fragment_frames = 300;  // of a fragment at most, those it shares with others included
  int overlap_frames = 30;    // that a fragment shares with the next
  // At the beginning of each recording, by which the depth camera is calibrated for all its
  // fragments: one is too short to do so by itself. 0 = the camera is as given.
  int camera_frames = 600;
  double tile_m = 4;     // side of a tile of the map, a cube of the world
  bool pictures = true;  // of the map, in the report

  void Visit(OptionVisitor& visitor);
};

// A stretch of a recording.
struct ScanFragment {
  std::string name;         // "0000", "0001", ... in their order, recording after recording
  int first = 0, last = 0;  // indices in the sequence, before its stride, both inclusive
  int recording = 0;        // position in the plan
};

// What the jobs of a scan begin with.
struct ScanPlan {
  SlamRunOptions run;  // of each fragment, but for its sequence and its output
  std::vector<SequenceOptions> recordings;
  std::vector<ScanFragment> fragments;
  int camera_frames = 0;
  double tile_m = 0;
  bool pictures = true;
};

// Cuts the frames first, first + stride, ... into the fewest fragments, all about as long, of which
// neighbours share overlap_frames. Throws InputError unless there is a frame.
std::vector<ScanFragment> CutIntoFragments(int first, int frame_count, int stride,
                                           int fragment_frames, int overlap_frames);

// Opens each sequence, which tells what is wrong with it, and writes into the scan's folder
// plan.json and, for each fragment, fragments/NAME.flags: what surfit_slam is to be given for it
// (--flagfile). So are, of each recording R (0, 1, ...), camera_R.flags, by which the camera is
// calibrated, and found_camera_R.flags, which come after a fragment's where it was found to be
// another one. Files that would say the same stay as they are, so that nothing is done again. No
// data are copied. Throws InputError for bad options, or a sequence that cannot be read.
ScanPlan PlanScan(const ScanPlanOptions& options);

// The plan in a scan's folder, with the cameras that were found. Throws InputError naming the file
// if it cannot be read or is no plan.
ScanPlan ReadScanPlan(const std::string& scan);

}  // namespace surfit
