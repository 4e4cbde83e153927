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
  int every = 10;            // interval of evaluated frames; unused if the run has held-out frames
  int pictures = 12;         // number of pictures, worst views first
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// Difference between a frame and the map rendered from its pose. Means for several views.
struct ViewError {
  double psnr_covered_db = 0, ssim_covered = 0;  // over pixels covered by the map
  double psnr_db = 0, ssim = 0;                  // over all pixels; uncovered pixels are black
  double psnr_covered_by_gain_db = 0;            // PsnrByGain() over covered pixels
  // Over covered pixels, from the pose that registers the colours of the frame to the map.
  double psnr_registered_db = 0, ssim_registered = 0;
  double coverage = 0;  // ratio of covered pixels
  // |rendered - measured| depth where both are valid.
  double depth_error_median_m = 0, depth_error_mean_m = 0;
};

struct EvaluatedView {
  int frame = 0;
  ViewError error;
};

// Results, which are also written to views.json and views.csv.
struct ViewEvaluation {
  bool held_out = false;  // the frames are not part of the map
  std::vector<EvaluatedView> views;
  ViewError mean;
  int without_color = 0;   // skipped frames
  std::string worst_view;  // path of its picture; empty: no picture
};

// Renders the map of a run from the poses of frames (DrawBlended()) and compares the views with the
// frames. The views include the rolling-shutter readout and the time offset of colour. Each view is
// also rendered from a pose that is registered by colour: the difference of both errors is the
// effect of the pose error. Pixels outside of the colour image, (0, 0, 0), are not compared.
// Writes views.json (means), views.csv (per view) and view_pictures/: frame, map and difference
// side by side, worst psnr_covered_db first. Calls `progress` with the number of processed views.
// Throws InputError for invalid options, unreadable files, a camera that differs from the camera of
// the run, or if no frame has both colour and a pose.
ViewEvaluation EvaluateViews(const ViewEvaluationOptions& options,
                             const std::function<void(int views)>& progress);

}  // namespace surfit
