#pragma once

#include <functional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

struct ViewEvaluationOptions {
  SequenceOptions sequence;  // sequence of the run, with the same options
  std::string run;           // output folder of a run, with poses.json, map.ply and summary.json
  std::string output;        // output folder, created if missing; empty: the folder of the run
  // Every n-th readable frame with a pose is evaluated, if it has colour. If the run has held-out
  // frames, all held-out frames are evaluated instead.
  int every = 10;
  int pictures = 12;  // maximum number of pictures, 0 to 100
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// Difference between a frame and a view of the map. Black frame pixels (0, 0, 0) have no colour and
// are not compared. Values without compared pixels are 0.
struct ViewError {
  double psnr_covered_db = 0, ssim_covered = 0;  // over pixels covered by the map
  double psnr_db = 0, ssim = 0;                  // over all pixels; black if not covered
  // As psnr_covered_db, by PsnrByGain().
  double psnr_covered_by_gain_db = 0;
  // As psnr_covered_db and ssim_covered, but at the pose of RegisterColors().
  double psnr_registered_db = 0, ssim_registered = 0;
  double coverage = 0;  // covered pixels / compared pixels
  // |rendered - measured| depth, over pixels that have both.
  double depth_error_median_m = 0, depth_error_mean_m = 0;
};

struct EvaluatedView {
  int frame = 0;  // index in the sequence
  ViewError error;
};

struct ViewEvaluation {
  bool held_out = false;  // the evaluated frames were not fused
  std::vector<EvaluatedView> views;
  ViewError mean;          // over the views
  int without_color = 0;   // skipped frames without colour
  std::string worst_view;  // path of the picture; empty: none
};

// Renders the map of a run at the poses of frames (DrawBlended()) and compares the views with
// the frames. The views include the rolling-shutter readout and the time offset of colour.
//
// Each frame is also registered to the map by its colours. The difference between
// psnr_registered_db and psnr_covered_db is the effect of errors of pose and colour timestamp.
//
// Replaces views.json (means), views.csv (all views) and view_pictures/ in the output folder. A
// picture shows frame, map and difference side by side, worst psnr_covered_db first. `progress`
// must not be empty. It receives the number of processed views. Unreadable frames are skipped.
//
// Throws InputError for:
// - invalid options
// - a sequence or a run that cannot be read
// - results that cannot be written
// - frames with another size than the calibration of the run
// - no selected frame with both colour and a pose
ViewEvaluation EvaluateViews(const ViewEvaluationOptions& options,
                             const std::function<void(int views)>& progress);

}  // namespace surfit
