#pragma once

#include <functional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// Which run is judged by its views, and by which of them.
struct ViewEvaluationOptions {
  SequenceOptions sequence;  // as the run read it
  std::string run;           // output folder of a run: poses.json, map.ply and summary.json
  std::string output;        // folder for the results, made if missing; empty: the run's
  int every = 10;            // of frames with a pose; a run that held frames out is judged by these
  int pictures = 12;         // of the worst views
  int threads = 2;           // that compute at the same time

  void Visit(OptionVisitor& visitor);
};

// How the map, drawn from a frame's pose, differs from the frame; of several views the means.
struct ViewError {
  double psnr_covered_db = 0, ssim_covered = 0;  // over the pixels that the map covers
  double psnr_db = 0, ssim = 0;                  // over all; black where it does not cover them
  double psnr_covered_by_gain_db = 0;            // PsnrByGain() over the pixels that it covers
  // From where the frame's own colours fit the map best, over the pixels that it covers there.
  double psnr_registered_db = 0, ssim_registered = 0;
  double coverage = 0;  // the share of the pixels, from the frame's pose
  // Of |drawn - measured| depth, where there are both, metres.
  double depth_error_median_m = 0, depth_error_mean_m = 0;
};

// A view of the map, and how far it is from the frame.
struct JudgedView {
  int frame = 0;  // index
  ViewError error;
};

// The outcome: what views.json and views.csv say.
struct ViewEvaluation {
  bool held_out = false;  // the frames were left out of the map
  std::vector<JudgedView> views;
  ViewError mean;
  int without_color = 0;   // frames left out
  std::string worst_view;  // its picture, empty without one
};

// Draws the map of a run (DrawBlended()) from the poses of frames and compares it with these. Each
// row is shown from where the camera was when it was read: rows one after the other, colour at its
// own stamp. How much of what differs is the pose's error is told by drawing each view once more
// from where its frame's own colours have it. Pixels that the colour camera does not see, (0, 0,
// 0), are not compared. Writes views.json (the means), views.csv (each view) and view_pictures/:
// frame, map and their difference side by side, the worst first, by psnr_covered_db. `progress` is
// called with the views done. Throws InputError for bad options, files that cannot be read, or a
// run without a frame to be judged by.
ViewEvaluation EvaluateViews(const ViewEvaluationOptions& options,
                             const std::function<void(int views)>& progress);

}  // namespace surfit
