#pragma once

#include <functional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

struct ViewEvaluationOptions {
  SequenceOptions sequence;  // sequence of the run, with the same options
  std::string run;           // output folder of a run: poses.json, map.ply and summary.json
  std::string output;        // output folder, created if missing; empty: the folder of the run
  // Every n-th frame with a pose is evaluated. Unused if the run has held-out frames: all of them
  // are evaluated.
  int every = 10;
  int pictures = 12;  // number of pictures, 0 to 100, worst views first
  int threads = 2;    // ThreadLimit

  void Visit(OptionVisitor& visitor);
};

// Difference between a frame and the map rendered from its pose. Only pixels with colour are
// compared, which are the pixels except (0, 0, 0). The PSNR is at most 100 dB. Values without
// compared pixels are 0.
struct ViewError {
  double psnr_covered_db = 0, ssim_covered = 0;  // over pixels covered by the map
  double psnr_db = 0, ssim = 0;  // over all compared pixels; uncovered pixels of the map are black
  // As psnr_covered_db, after correction of exposure and white balance: PsnrByGain().
  double psnr_covered_by_gain_db = 0;
  // As psnr_covered_db and ssim_covered, but the map is rendered from the pose of RegisterColors().
  double psnr_registered_db = 0, ssim_registered = 0;
  double coverage = 0;  // ratio of covered pixels to compared pixels
  // |rendered - measured| depth, over pixels where both are valid.
  double depth_error_median_m = 0, depth_error_mean_m = 0;
};

struct EvaluatedView {
  int frame = 0;  // index in the sequence
  ViewError error;
};

// Results, which are also written to views.json and views.csv.
struct ViewEvaluation {
  bool held_out = false;  // the frames are not part of the map
  std::vector<EvaluatedView> views;
  ViewError mean;          // means of the values of all views
  int without_color = 0;   // selected frames that were skipped, because they have no colour
  std::string worst_view;  // path of its picture; empty: no picture
};

// Renders the map of a run from the poses of frames (DrawBlended()) and compares the views with the
// frames. The views include the rolling-shutter readout and the time offset of colour.
//
// Each frame is also registered to the map by its colours, and the view is rendered again from this
// pose. The difference between psnr_registered_db and psnr_covered_db is the effect of errors of
// the pose and of the colour timestamp.
//
// Deletes former results in the output folder. Writes views.json (means), views.csv (per view) and
// view_pictures/: frame, map and difference side by side, worst psnr_covered_db first. Calls
// `progress`, which must not be empty, with the number of processed views. Unreadable frames are
// skipped.
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
