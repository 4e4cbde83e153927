#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

class OptionVisitor;

// Loop closure: options and callbacks. Depends on place recognition, poses and optimization. Read
// src/loop_closure/loop_closer.h next.

// Uncertainty added to pose graph edges. The odometry covariance is the registration covariance,
// times `shared_points`, times the number of frames between the keyframes. Drift is a random walk,
// largest along weakly constrained directions. Errors of the calibration and of the surface model
// do not average out. They are standard deviations per component, and are added to the covariance
// of every edge.
struct EdgeNoise {
  double shared_points = kSharedPoints;
  double odometry_m = 0.0002;     // between consecutive keyframes, m
  double odometry_rad = 0.0001;   // between consecutive keyframes, rad
  double odometry_ratio = 0.001;  // additional ratio of the translation and rotation between them
  double loop_m =
      0.003;  // of loop closures, in addition to GlobalRegistrationResult::information, m
  double loop_rad = 0.0015;  // of loop closures, rad

  void Visit(OptionVisitor& visitor);
};

// Options of the pose graph with outlier rejection of loop closures by GNC. Starts from odometry
// and ends rounds early, because the graph is solved again after each loop closure.
inline PoseGraphOptions RobustPoseGraphOptions() {
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  options.start = "odometry";
  options.max_round_iterations = 10;
  options.min_round_cost_change = 1e-3;
  return options;
}

// Options of loop closure and relocalisation.
struct LoopOptions {
  bool enabled = false;
  KeyframeOptions keyframes;
  PlaceViewOptions views;
  PlaceIndexOptions places;
  FindLoopsOptions find;
  RelocalizeOptions relocalize;
  EdgeNoise noise;
  PoseGraphOptions graph = RobustPoseGraphOptions();
  // Loop closures of a keyframe are applied this many frames later, so that the result does not
  // depend on the machine. In real time, they may be applied later.
  int delay_frames = 30;
  // Value of FusionOptions::active_frames with loop closure, if that option is 0. Old surfels must
  // not constrain a drifted camera before a loop closure corrects the drift. 0: no limit.
  int active_frames = 200;
  // Minimum number of frames between the observations of duplicate surfels that a loop closure
  // merges. It counts from the last observation of the older surfel to the first observation of the
  // newer surfel. FusionOptions::active_frames is used instead if it is larger.
  int frames_apart = 100;
  // Loop closures do not move the map if the displacement of each keyframe is at most this value.
  // The displacement is the translation plus 2 m times the rotation in rad.
  double min_correction_m = 0.002;
  // Memory of keyframe views, for LimitKeyframes().
  std::size_t max_view_bytes = std::size_t{512} << 20;
  // Number of consecutive lost frames after which a new submap starts. A loop closure connects it
  // to the first submap. 0: never.
  int new_map_after = 0;

  void Visit(OptionVisitor& visitor);
};

// Finds and verifies loop closures of keyframe `source`, a position in `keyframes`: FindLoops() or
// another method. Runs in the background thread of loop closure, or in the thread of Slam if only
// one thread may compute. Exceptions are thrown again by the call of Slam that applies the result.
using LoopFinder = std::function<std::vector<LoopVerification>(
    int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index)>;

// Returns the view of a keyframe. The view is computed at the first call. Safe from any thread.
using ViewOfKeyframe = std::function<PlaceView()>;

}  // namespace surfit
