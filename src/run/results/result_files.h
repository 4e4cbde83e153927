#pragma once

#include <optional>
#include <string>
#include <vector>

#include "finishing/found_sensor.h"
#include "run/results/kept_views.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/run/slam_run.h"
#include "surfit/slam/backend.h"

namespace surfit {

// Writes summary.json: what is known of the run, null where it is not. Throws InputError naming
// the file if it cannot be written.
void WriteSummaryJson(const SlamRunSummary& summary, const SlamRunOptions& options,
                      const std::string& path);

// Where a run's cameras were, in the frame of its map.
struct RunPoses {
  const PinholeCamera& camera;
  const FoundSensor& found;        // of the frames as they are read
  const Trajectory& trajectory;    // as estimated
  const std::vector<int>& frames;  // of the trajectory's poses: the frames' indices
  const Trajectory& truth;         // in its own world; empty if unknown
  const std::optional<TrajectoryEvaluation>& evaluation;
  const std::vector<KeptView>& views;
  const std::vector<KeptView>& thumbnails;
  const std::vector<KeyframeLink>& keyframes;
};

// Writes, in metres and in the frame of map.ply (trajectory.txt is in the sequence's own):
//   camera          width height fx fy cx cy, pixels
//   calibration     what the run found of the frames as they are read: fx fy cx cy, pixels,
//                   inverse_depth_field, 1/m, readout_s; null where the camera is as given
//   color_latency_s by how much colour was found to be earlier than the frames have it
//   poses           of each tracked frame: index stamp_s tx ty tz qx qy qz qw, camera-to-world
//   truth           positions of the ground truth, moved onto the estimate as for ATE: stamp_s tx
//                   ty tz; null where unknown, or where nothing says how to move it
//   errors_m        of each frame with a true pose: index, distance from that position; or null
//   views           of each KeptView: index, stamp_s, and files: picture's name to path
//   thumbnails      the same of Thumbnails
//   keyframes       of each KeyframeLink: frame, parent_frame (-1: none), submap
// Throws InputError naming the file if it cannot be written.
void WritePosesJson(const RunPoses& run, const std::string& path);

// Writes all loops that were tried, one per line, with the figures and the reason of the verdict.
// The pose graph may have overruled a verdict. Loops of earlier runs of a session are left out.
// Throws InputError naming the file.
void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path);

}  // namespace surfit
