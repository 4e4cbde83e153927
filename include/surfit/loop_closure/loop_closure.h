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

// What registrations do not know of their errors. The covariance of odometry is what they say,
// times the points that share one error and the frames between the keyframes: drift is a walk at
// random, and goes above all where a view holds the camera least. Errors of calibration and of
// surfaces that are not what the model of noise says do not average out at all: they are added to
// the covariance of every edge of the pose graph, as standard deviations of each component.
struct EdgeNoise {
  double shared_points = kSharedPoints;
  double odometry_m = 0.0002;     // between consecutive keyframes, and
  double odometry_rad = 0.0001;   //
  double odometry_share = 0.001;  // of the way and of the turn between them
  double loop_m = 0.003;          // of a loop, beyond FarVerdict::information
  double loop_rad = 0.0015;

  void Visit(OptionVisitor& visitor);
};

// Of loops: wrong ones are left out.
inline PoseGraphOptions RobustPoseGraphOptions() {
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  return options;
}

// How loops are closed, and how a lost camera is found again.
struct LoopOptions {
  bool enabled = false;
  KeyframeOptions keyframes;
  PlaceViewOptions views;
  PlaceIndexOptions places;
  FindLoopsOptions find;
  RelocalizeOptions relocalize;
  EdgeNoise noise;
  PoseGraphOptions graph = RobustPoseGraphOptions();
  // What is found out from a keyframe on takes effect before the so-many-th frame after it, however
  // long it takes: the same on every machine.
  int delay_frames = 30;
  // FusionOptions::active_frames where loops are closed and that sets no limit: what the camera has
  // drifted from must not hold it until a loop has put both together. 0 = no limit either.
  int active_frames = 200;
  // Surfels last seen longer before others were first seen are merged with these where a loop puts
  // them together; FusionOptions::active_frames where that is more.
  int frames_apart = 100;
  // A correction that moves no keyframe farther is not applied: the map is as good as it was.
  double min_correction_m = 0.002;
  std::size_t max_view_bytes = std::size_t{512} << 20;  // of keyframes: LimitKeyframes()
  // After so many lost frames in a row a new map is begun, and joined to the first by a loop. 0 =
  // never.
  int new_map_after = 0;

  void Visit(OptionVisitor& visitor);
};

// Tries to join keyframe `source` to earlier ones: FindLoops(), or another way.
using LoopFinder = std::function<std::vector<LoopAttempt>(
    int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index)>;

// A keyframe's view, made by whichever thread asks for it first.
using ViewOfKeyframe = std::function<PlaceView()>;

}  // namespace surfit
