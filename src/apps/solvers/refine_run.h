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
  std::string trajectory;    // trajectory of the run: TUM format, pose convention of the sequence
  std::string output;        // output folder, created if missing
  // Minimum translation since the last keyframe. A rotation of 0.15 rad is also sufficient.
  double keyframe_translation_m = 0.1;
  // Maximum number of keyframes; see ChooseKeyframes(). 0: no limit. A keyframe uses about 32
  // bytes per pixel.
  int max_keyframes = 600;
  PreprocessOptions preprocess;
  RefinementOptions refinement;
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

struct RefineRunSummary {
  RefinementSummary refinement;
  // Input and estimated calibration of the undistorted, downsampled images, with fy > 0. Both are
  // equal if the refinement failed.
  DepthCalibration given, calibration;
  std::size_t poses = 0, keyframes = 0;
  int frames_without_pose = 0;
  int frames_unreadable = 0;
  // Errors before and after refinement; std::nullopt without ground truth, or if the refinement
  // failed.
  std::optional<TrajectoryEvaluation> before, after;
  std::size_t map_points = 0;  // surfels of map.ply; 0: not written
  double total_s = 0;
  std::string failure;  // messages of results that were not written; RunRefinement() then throws
};

// Refines keyframes and calibration of a run (Refine()), corrects the other poses, and fuses the
// map again. Writes refinement.json and, if refinement succeeded, trajectory.txt, map.ply,
// camera.yaml and poses.json. `progress` receives log lines and must not be empty. Throws
// InputError for invalid options, unreadable files, or a trajectory without poses at frames of
// the sequence. Also throws InputError if a result cannot be written, after it has written the
// other results.
RefineRunSummary RunRefinement(const RefineRunOptions& options,
                               const std::function<void(const std::string&)>& progress);

}  // namespace surfit
