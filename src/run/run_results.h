#pragma once

#include <optional>
#include <vector>

#include "finishing/posed_sequence.h"
#include "output/pictures/pictures.h"
#include "run/results/failures.h"
#include "run/results/kept_views.h"
#include "run/results/run_files.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Results of a run. References must be valid during WriteRunResults().
struct RunOutcome {
  const SequenceInfo& info;
  const RunTrajectory& trajectory;
  const Trajectory& largest_piece;  // part of the trajectory; `evaluation` is for it
  const EstimatedSensor& found;
  const Backend* backend;  // null: no loop closure and no calibration
  const SurfelMap& map;
  const KeptViews& views;
  const Thumbnails& thumbnails;
  const std::vector<double>& stamps_s;                    // of all frames, s
  const std::optional<TrajectoryEvaluation>& evaluation;  // std::nullopt: no ground truth
  const std::optional<UprightWorld>& upright;             // std::nullopt: keep the world frame
  const SlamRunOptions& options;
};

// Writes map, views, poses and pictures into the output folder. Adds errors to `failures` and
// continues. Call after the last correction of trajectory and map.
void WriteRunResults(const RunOutcome& run, Failures* failures);

}  // namespace surfit
