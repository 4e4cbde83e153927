#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run/kept_views.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Where a run's cameras were, in the frame of its map.
struct RunPoses {
  const PinholeCamera& camera;
  const Trajectory& trajectory;    // as estimated
  const std::vector<int>& frames;  // of the trajectory's poses: the frames' indices
  const Trajectory& truth;         // in its own world; empty if unknown
  const std::optional<TrajectoryEvaluation>& evaluation;
  const std::vector<KeptView>& views;
};

// Writes, in metres and in the frame of map.ply (trajectory.txt is in the sequence's own):
//   camera          width height fx fy cx cy, pixels
//   poses           of each tracked frame: index stamp_s tx ty tz qx qy qz qw, camera-to-world
//   truth           positions of the ground truth, moved onto the estimate as for ATE: stamp_s tx
//                   ty tz; null where unknown, or where nothing says how to move it
//   errors_m        of each frame with a true pose: index, distance from that position; or null
//   views           of each KeptView: index, stamp_s, and files: picture's name to path
// Throws InputError naming the file if it cannot be written.
void WritePosesJson(const RunPoses& run, const std::string& path);

}  // namespace surfit
