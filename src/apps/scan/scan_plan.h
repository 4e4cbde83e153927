#pragma once

#include <string>
#include <vector>

#include "surfit/run/slam_run.h"

namespace surfit {

class OptionVisitor;

// Options of PlanScan(), which splits recordings of one place into fragments. Fragments are tracked
// independently.
struct ScanPlanOptions {
  std::vector<std::string> sequences;
  // Options of the fragment runs. `output` is the folder of the scan. `sequence` has the read
  // options of all recordings.
  SlamRunOptions run;
  int fragment_frames = 300;  // maximum, including shared frames
  int overlap_frames = 30;    // shared by consecutive fragments
  // Number of frames at the start of each recording for the calibration of the depth camera. A
  // single fragment is too short for a calibration. 0: no calibration.
  int camera_frames = 600;
  double tile_m = 4;     // edge length of a map tile
  bool pictures = true;  // pictures of the map in the report

  void Visit(OptionVisitor& visitor);
};

// Segment of a recording.
struct ScanFragment {
  std::string name;         // "0000", "0001", ... through all recordings
  int first = 0, last = 0;  // frame indices in the sequence, both inclusive
  int recording = 0;        // position in the plan
};

struct ScanPlan {
  SlamRunOptions run;  // options of the fragment runs, except sequence and output
  std::vector<SequenceOptions> recordings;
  std::vector<ScanFragment> fragments;
  int camera_frames = 0;
  double tile_m = 0;
  bool pictures = true;
};

// Splits the frames first, first + stride, ... into the smallest number of fragments, with about
// equal lengths. Consecutive fragments share overlap_frames. Throws InputError without a frame.
std::vector<ScanFragment> CutIntoFragments(int first, int frame_count, int stride,
                                           int fragment_frames, int overlap_frames);

// Opens each sequence to check it, and writes plan.json and the flag files of surfit_slam
// (--flagfile) into the folder of the scan:
//   fragments/NAME.flags    run of a fragment
//   camera_R.flags          calibration run of recording R (0, 1, ...)
//   found_camera_R.flags    calibrated camera of recording R, in addition to fragments/NAME.flags
// Unchanged files keep their modification time, so that finished jobs are not repeated. No data are
// copied. Throws InputError for invalid options, or a sequence that cannot be read.
ScanPlan PlanScan(const ScanPlanOptions& options);

// Reads the plan of a scan, with the calibrated cameras. Throws InputError with the name of the
// file if the plan is missing or invalid.
ScanPlan ReadScanPlan(const std::string& scan);

}  // namespace surfit
