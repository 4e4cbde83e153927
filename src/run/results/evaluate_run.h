#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include "run/results/run_files.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/poses/pose_store.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Pieces of a trajectory, and the poses of the piece with the most frames.
struct TrajectoryPieces {
  std::vector<TrajectoryPiece> all;
  Trajectory largest;
};

// Splits the trajectory of a run into the pieces of its pose graph, in the order of the piece
// numbers. `poses`: null without a pose graph, which gives one piece. `truth`: ground truth in its
// own world frame; empty: no evaluation of the pieces. `stamps_s`: timestamps of all frames.
TrajectoryPieces SplitIntoPieces(const RunTrajectory& trajectory, const PoseStore* poses,
                                 const Trajectory& truth, const std::vector<double>& stamps_s);

// Positions p in the trajectory with 1 to 10 lost frames between the positions p and p + 1, if both
// positions are in the same piece. `lost`: indices of lost frames. `poses`: as above.
std::vector<std::size_t> GapsOf(const RunTrajectory& trajectory, const PoseStore* poses,
                                const std::set<int>& lost);

// Adds the poses of bridged frames that are not among the found ones. Their frames before must be
// in the trajectory.
void AddBridgedFrames(const std::vector<Slam::BridgedFrame>& bridged,
                      const RunTrajectory& trajectory, std::vector<PoseBetween>* found);

// Sets the errors of the summary for the poses of the largest piece. Logs a warning if the ground
// truth of `options` has no pose at the times of the frames. `truth` must not be empty.
void EvaluateRun(const Trajectory& estimate, const Trajectory& truth,
                 const std::vector<double>& stamps_s, const SlamRunOptions& options,
                 SlamRunSummary* summary);

}  // namespace surfit
