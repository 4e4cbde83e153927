#pragma once

#include <cstddef>
#include <vector>

#include "surfit/optimization/pose_graph.h"
#include "surfit/registration/initialize.h"
#include "surfit/slam/loop_finder.h"
#include "surfit/slam/loop_options.h"

namespace surfit {

// A keyframe that is to be joined to earlier ones.
struct NewKeyframe {
  Keyframe keyframe;                 // its view is still to be made
  ColoredView view;                  // of this
  std::vector<PoseGraphEdge> edges;  // odometry from earlier keyframes: b is this one
};

// What is to be done at once, and where all keyframes are, the new ones included.
struct LoopTask {
  std::vector<NewKeyframe> added;
  std::vector<Rigid3d> world_from_keyframe;
};

// What came of it.
struct LoopOutcome {
  std::vector<LoopRecord> attempts;
  bool optimised = false;                    // there are new loops, and the graph could be solved
  std::vector<Rigid3d> world_from_keyframe;  // of all keyframes, if optimised
  std::vector<bool> loops_in_graph;          // of all accepted loops so far, if optimised
  std::size_t given_up_views = 0;            // by LimitKeyframes()
};

// Finds and closes loops: keyframes, the index of their places, and the pose graph between them.
class LoopCloser {
 public:
  LoopCloser(const LoopOptions& options, LoopFinder finder);

  LoopOutcome Run(LoopTask task);

  // Looks for a view among all keyframes that were added.
  Relocalization Find(const ColoredView& view, const std::vector<Rigid3d>& world_from_keyframe);

 private:
  void Add(NewKeyframe added);
  void SetPoses(const std::vector<Rigid3d>& world_from_keyframe);
  void TryLoops(int source, LoopOutcome* outcome);
  void Optimise(LoopOutcome* outcome) const;

  LoopOptions options_;
  LoopFinder finder_;
  std::vector<Keyframe> keyframes_;
  PlaceIndex index_;
  PoseGraph graph_;
};

}  // namespace surfit
