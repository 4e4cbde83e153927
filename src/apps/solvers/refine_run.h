#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/sequence.h"
#include "surfit/optimization/refine.h"

namespace surfit {

class OptionVisitor;

// What is refined, and with which frames.
struct RefineRunOptions {
  SequenceOptions sequence;  // as the run read it
  std::string trajectory;    // of the run: TUM format, in the sequence's convention
  std::string output;        // folder for all results; made if missing
  // A frame is a keyframe if the camera has moved so far from the last one, in one way or the
  // other.
  double keyframe_translation_m = 0.1;
  double keyframe_rotation_rad = 0.15;
  // With more of them, both are enlarged; 0 = no limit. A keyframe takes 16 bytes for each pixel,
  // and as much again for what it has measured of surfels.
  int max_keyframes = 600;
  PreprocessOptions preprocess;
  RefinementOptions refinement;
  int threads = 2;  // that compute at the same time

  void Visit(OptionVisitor& visitor);
};

// The outcome: what refinement.json says.
struct RefineRunSummary {
  RefinementSummary refinement;
  // Of the undistorted and downsampled images, y down; before, and after where refinement
  // succeeded.
  DepthCalibration given, calibration;
  std::size_t poses = 0, keyframes = 0;
  int frames_without_pose = 0;  // of those read: the run had lost them
  int frames_unreadable = 0;
  // Of the trajectory before and after, where there is ground truth.
  std::optional<TrajectoryEvaluation> before, after;
  std::size_t map_points = 0;
  double total_s = 0;
  std::string failure;  // what was not written
};

// Refines the keyframes of a run and, as the options say, the camera's calibration; moves the other
// poses along, and fuses the map anew. Writes trajectory.txt, map.ply, camera.yaml and
// refinement.json, the first three only where refinement succeeded.
// Throws InputError for bad options, files that cannot be read, or a trajectory of other frames.
// What goes wrong once it is refined is thrown, too, when all else is written.
RefineRunSummary RunRefinement(const RefineRunOptions& options,
                               const std::function<void(const std::string&)>& progress);

}  // namespace surfit
