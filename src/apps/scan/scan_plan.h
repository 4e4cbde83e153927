#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

class OptionVisitor;

// A scan splits recordings of one place into fragments, which are tracked independently.
struct ScanPlanOptions {
  std::vector<std::string> sequences;  // paths of the recordings, all different
  // `run.output`: folder of the scan. `run.sequence`: options of all recordings, without path.
  SlamRunOptions run;
  int fragment_frames = 300;  // maximum length, including the overlap
  int overlap_frames = 30;    // shared frames of consecutive fragments
  // Number of frames at the start of each recording for the calibration of the depth camera.
  // 0: no calibration. Single fragments are too short.
  int camera_frames = 600;
  double tile_m = 4;  // edge length of a map tile
  bool pictures = true;

  void Visit(OptionVisitor& visitor);
};

// Part of a recording with a separate map.
struct ScanFragment {
  std::string name;         // "0000", "0001", ..., unique in the scan
  int first = 0, last = 0;  // frame indices in the sequence, both inclusive
  int recording = 0;        // index in ScanPlan::recordings
};

// Content of plan.json.
struct ScanPlan {
  SlamRunOptions run;  // options of the fragment runs, except sequence and output
  std::vector<SequenceOptions> recordings;
  std::vector<ScanFragment> fragments;
  int camera_frames = 0;
  double tile_m = 0;
  bool pictures = true;
};

// Splits the frames first, first + stride, ... into as few fragments as possible, with nearly equal
// lengths. Requires overlap_frames < fragment_frames. Throws InputError without frames. Lengths are
// in selected frames. The names count from "0000", and `recording` is 0.
std::vector<ScanFragment> CutIntoFragments(int first, int frame_count, int stride,
                                           int fragment_frames, int overlap_frames);

// Opens each sequence, and writes plan.json and flag files of surfit_slam (--flagfile) into the
// folder of the scan:
//   fragments/NAME.flags    run of a fragment
//   camera_R.flags          calibration run of recording R (0, 1, ...)
//   found_camera_R.flags    calibrated camera of recording R, in addition to fragments/NAME.flags
// Unchanged files keep their modification time, so that finished jobs are not repeated. Throws
// InputError for invalid options, a sequence that cannot be read, or files that cannot be written.
// The fragments run with loop closure, and without calibration, refinement, final map and pictures.
// camera_R.flags is written only if camera_frames is positive.
ScanPlan PlanScan(const ScanPlanOptions& options);

// Reads plan.json, and sets the cameras that are already calibrated. Throws InputError with the
// file name if the plan is missing or invalid.
ScanPlan ReadScanPlan(const std::string& scan);

}  // namespace surfit
