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

struct RefineRunOptions {
  SequenceOptions sequence;  // sequence of the run, with the same options
  std::string trajectory;    // of the run: TUM format, pose convention of the sequence
  std::string output;        // output folder, created if missing
  // Minimum translation or rotation since the last keyframe for a new keyframe.
  double keyframe_translation_m = 0.1;
  double keyframe_rotation_rad = 0.15;
  // Maximum number of keyframes: both limits grow until it holds. 0: no limit. A keyframe uses 16
  // bytes per pixel for images, and about 16 more for observations of surfels.
  int max_keyframes = 600;
  PreprocessOptions preprocess;
  RefinementOptions refinement;
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

// Results, which are also written to refinement.json.
struct RefineRunSummary {
  RefinementSummary refinement;
  // Calibration of the undistorted and downsampled images, y down: input, and estimate if
  // refinement succeeded.
  DepthCalibration given, calibration;
  std::size_t poses = 0, keyframes = 0;
  int frames_without_pose = 0;  // frames that the run lost
  int frames_unreadable = 0;
  // Errors before and after refinement; std::nullopt without ground truth.
  std::optional<TrajectoryEvaluation> before, after;
  std::size_t map_points = 0;
  double total_s = 0;
  std::string failure;  // errors of files that were not written
};

// Refines the keyframes of a run and, depending on the options, the calibration of the camera.
// Corrects the other poses, and fuses the map again. Writes refinement.json and, if refinement
// succeeded, trajectory.txt, map.ply, camera.yaml and poses.json. Throws InputError for invalid
// options, unreadable files, or a trajectory without a pose at a frame of the sequence. If a result
// cannot be written, writes the other results before it throws InputError.
RefineRunSummary RunRefinement(const RefineRunOptions& options,
                               const std::function<void(const std::string&)>& progress);

}  // namespace surfit
