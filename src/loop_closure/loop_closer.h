#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/background_task.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/poses/pose_store.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

// Callback that computes the place view of a keyframe at its first call, and then releases the
// source. `field`: PlaceView::field.
ViewOfKeyframe ViewOf(ColoredView source, const InverseDepthField& field,
                      const PlaceViewOptions& options);

// Edge of an accepted loop: a is the target keyframe, b the source keyframe.
PoseGraphEdge LoopEdge(const LoopVerification& attempt, const EdgeNoise& noise);

struct KeyframeForLoops {
  int frame_index = 0;
  double stamp_s = 0;
  ViewOfKeyframe view;
};

// Input of a task: the keyframes since the last task, and a PoseStore::Snapshot() with all
// keyframes of all tasks. Pose positions are keyframe positions.
struct LoopTask {
  std::vector<KeyframeForLoops> added;
  PoseGraph graph;
  // Keyframe::piece, one per pose of the graph: see PoseStore. Without loop closure, this is the
  // submap, so that loops between joined submaps are found, too.
  std::vector<int> piece_of_keyframe;
};

// Result of a task, applied to the pose store by the caller.
struct LoopOutcome {
  std::vector<LoopRecord> attempts;  // all verified candidates, also rejected ones
  // False: no new loop, or the optimisation failed. The next two vectors are then empty.
  bool optimised = false;
  std::vector<Rigid3d> world_from_keyframe;  // per keyframe of the snapshot
  std::vector<bool> loops_in_graph;          // per loop edge, including new loops; false: outlier
  std::size_t removed_views = 0;             // number of views that LimitKeyframes() removed
};

// Finds loops and optimises the pose graph in background tasks. Owns the keyframe views and their
// place index. Works on snapshots of the pose store. Not thread-safe: one thread calls all
// functions. The destructor waits for a running task.
class LoopCloser {
 public:
  // A null `finder` stands for FindLoops(). If `always_in_background`, tasks have their own thread
  // even if one thread may compute. Throws InputError for invalid LoopOptions::places.
  LoopCloser(const LoopOptions& options, LoopFinder finder, bool always_in_background);

  // Sets the keyframes of a saved state, in their order, and applies LimitKeyframes(). Call at most
  // once, before the first task. Keyframes without a view keep their position.
  void AddSettled(std::vector<Keyframe> keyframes);

  // Starts a task, whose result is due after LoopOptions::delay_frames. Requires that no task is
  // pending. Get the result by task().Take(), which rethrows exceptions of the finder.
  void Start(LoopTask task);
  BackgroundTask<LoopOutcome>& task() { return task_; }

  // Relocalises a view by one keyframe of all tasks: RelocalizeOptions::first_candidate is `rank`.
  // `world_from_keyframe` has at least one current pose per keyframe. Waits for the current task,
  // and keeps its outcome for Take().
  Relocalization Find(const ColoredView& view, int rank,
                      const std::vector<Rigid3d>& world_from_keyframe);
  // Registers a view to the view of an earlier frame. Thread-safe.
  GlobalRegistrationResult RegisterTo(const ColoredView& earlier, const ColoredView& view) const;

  // Calibration of all views, also those of later tasks. Requires that no task is running. Null:
  // the views keep their calibrations.
  void UseCalibration(const std::optional<DepthCalibration>& calibration);

  // Keyframes of all tasks, with the poses of the last task or Find(). Requires that no task is
  // running. Valid until the next Start().
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

 private:
  LoopOutcome Run(LoopTask task);
  void RecalibrateViews(int first);
  void TryLoops(int source, PoseGraph* graph, LoopOutcome* outcome);
  void Optimise(PoseGraph graph, LoopOutcome* outcome) const;

  LoopOptions options_;
  LoopFinder finder_;
  std::optional<DepthCalibration> calibration_;
  std::vector<Keyframe> keyframes_;
  PlaceIndex index_;
  BackgroundTask<LoopOutcome> task_;  // last member: the destructor waits for the task
};

}  // namespace surfit
