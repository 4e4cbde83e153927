#pragma once

#include <cstddef>
#include <vector>

#include "core/spare_time.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/backend.h"

namespace surfit {

// The edge of the pose graph that a loop makes, which was accepted.
PoseGraphEdge LoopEdge(const LoopAttempt& attempt, const EdgeNoise& noise);

// Edges as another calibration of the camera measures them, which has moved the keyframes: what was
// measured differs from their poses by as much as before.
void Recalibrate(const std::vector<Rigid3d>& before, const std::vector<Rigid3d>& after,
                 std::vector<PoseGraphEdge>* edges);

// A keyframe that is to be joined to earlier ones.
struct NewKeyframe {
  Keyframe keyframe;                 // its view is still to be taken
  ViewOfKeyframe view;               // from here
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

// Finds and closes loops beside tracking: keyframes, the index of their places, and the pose graph
// between them.
class LoopCloser {
 public:
  // Where `always_beside`, tasks are SpareTimeTask's.
  LoopCloser(const LoopOptions& options, LoopFinder finder, bool always_beside);

  // Takes up keyframes with their views, and the edges between them; before any task.
  void GoOnFrom(std::vector<Keyframe> keyframes, std::vector<PoseGraphEdge> edges);

  // Begins a task, whose outcome task().Take() gives.
  void Start(LoopTask task);
  SpareTimeTask<LoopOutcome>& task() { return task_; }

  // No task may be under way: surfit::Recalibrate() of its edges.
  void Recalibrate(const std::vector<Rigid3d>& before, const std::vector<Rigid3d>& after);

  // Looks for a view among all keyframes that were added, once no task is at work. Its outcome can
  // still be taken.
  Relocalization Find(const ColoredView& view, const std::vector<Rigid3d>& world_from_keyframe);

  // No task may be under way. All that were added, with their views; where they are, frames tell.
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

 private:
  LoopOutcome Run(LoopTask task);
  void Add(Keyframe keyframe);
  void SetPoses(const std::vector<Rigid3d>& world_from_keyframe);
  void TryLoops(int source, LoopOutcome* outcome);
  void Optimise(LoopOutcome* outcome) const;

  LoopOptions options_;
  LoopFinder finder_;
  std::vector<Keyframe> keyframes_;
  PlaceIndex index_;
  PoseGraph graph_;
  SpareTimeTask<LoopOutcome> task_;  // last: it is waited for before the others go
};

}  // namespace surfit
