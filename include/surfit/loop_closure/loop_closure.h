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

// Loop closure: options and callbacks. Read src/loop_closure/loop_closer.h next.

// Uncertainty of pose graph edges. The covariance of an odometry edge is the registration
// covariance times `shared_points` times the number of frames. Calibration and surface errors do
// not average out, so the members below add variances per component. Relocalisation edges have the
// noise of loop closures.
struct EdgeNoise {
  double shared_points = kSharedPoints;
  double odometry_m = 0.0002;     // between consecutive keyframes, m
  double odometry_rad = 0.0001;   // between consecutive keyframes, rad
  double odometry_ratio = 0.001;  // fraction of the translation and rotation of the edge
  double loop_m = 0.003;          // of loop closures, in addition to their registration, m
  double loop_rad = 0.0015;       // of loop closures, in addition to their registration, rad

  void Visit(OptionVisitor& visitor);
};

// Pose graph options that reject outlier loop closures by GNC.
inline PoseGraphOptions RobustPoseGraphOptions() {
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  options.start = "odometry";
  options.max_round_iterations = 10;
  options.min_round_cost_change = 1e-3;
  return options;
}

// Options of loop closure and relocalisation. `keyframes` is also used for calibration without
// keyframe views.
struct LoopOptions {
  // Closes loops within a piece of the trajectory, too. Implies `relocalization`.
  bool enabled = true;
  // Relocalises a lost camera, starts submaps, and joins submaps by loop closures between them. Has
  // no effect on a camera that is never lost.
  bool relocalization = true;
  KeyframeOptions keyframes;
  PlaceViewOptions views;
  PlaceIndexOptions places;
  FindLoopsOptions find;
  RelocalizeOptions relocalize;
  EdgeNoise noise;
  PoseGraphOptions graph = RobustPoseGraphOptions();
  // Number of frames from the start of a loop task until its result is applied, on every machine.
  // In real time, it may be applied later. A task has all keyframes since the last task.
  int delay_frames = 30;
  // FusionOptions::active_frames if `enabled` is true and that option is 0. Old surfels must not
  // constrain a drifted camera before a loop closure. 0: no limit.
  int active_frames = 200;
  // Duplicate surfels are merged after a loop closure if more than this number of frames is between
  // their observations. FusionOptions::active_frames is used instead if it is larger.
  int frames_apart = 100;
  // Maximum memory of keyframe views, bytes. LimitKeyframes() removes further views.
  std::size_t max_view_bytes = std::size_t{512} << 20;
  // A new submap starts with this lost frame in a row. Frames with too little depth do not count. A
  // loop closure can connect the submap to the first submap. 0: never.
  int new_map_after = 6;

  // Returns whether keyframes have views, for loop closure or relocalisation.
  bool HasViews() const { return enabled || relocalization; }

  void Visit(OptionVisitor& visitor);
};

// Finds and verifies loop closures of keyframe `source`, a position in `keyframes`. The default is
// FindLoops(). The targets must be earlier keyframes. LoopCandidate::source of the result is
// ignored. References are valid during the call. Called in the background thread of loop closure,
// or in the thread of Slam with one computing thread. An exception is thrown again by Slam when the
// result is applied.
using LoopFinder = std::function<std::vector<LoopVerification>(
    int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index)>;

// Returns the view of a keyframe, which is computed at the first call. Thread-safe: concurrent
// first calls may both compute the view.
using ViewOfKeyframe = std::function<PlaceView()>;

}  // namespace surfit
