#pragma once

#include <chrono>
#include <cstddef>
#include <future>
#include <utility>
#include <vector>

#include "surfit/core/parallel.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/backend.h"

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

  // The poses of all keyframes are what another calibration of the camera makes of them; their
  // relative motions, too.
  void Recalibrate(const std::vector<Rigid3d>& before, const std::vector<Rigid3d>& after);

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

// Closes loops on a thread of its own, one task at a time, in time that tracking leaves; where only
// one thread may compute, when the outcome is asked for.
class LoopThread {
 public:
  LoopThread(const LoopOptions& options, LoopFinder finder) : closer_(options, std::move(finder)) {}

  // None may be under way.
  void Start(LoopTask task) {
    const bool is_beside = ThreadCount() > 1;
    const auto launch = is_beside ? std::launch::async : std::launch::deferred;
    task_ = std::async(launch, [this, is_beside, started = std::move(task)]() mutable {
      LoopOutcome outcome;
      const auto run = [&] { outcome = closer_.Run(std::move(started)); };
      is_beside ? RunInSpareTime(run) : run();
      return outcome;
    });
  }

  // A task was begun whose outcome has not been taken.
  bool HasTask() const { return task_.valid(); }
  bool IsLate() const {
    return task_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
  }
  LoopOutcome Take() { return task_.get(); }

  // None may be under way.
  void Recalibrate(const std::vector<Rigid3d>& before, const std::vector<Rigid3d>& after) {
    closer_.Recalibrate(before, after);
  }

  // LoopCloser::Find(), once no task is at work. Its outcome can still be taken.
  Relocalization Find(const ColoredView& view, const std::vector<Rigid3d>& world_from_keyframe) {
    if (HasTask()) task_.wait();
    return closer_.Find(view, world_from_keyframe);
  }

 private:
  LoopCloser closer_;
  std::future<LoopOutcome> task_;  // last: it is waited for before the closer goes
};

}  // namespace surfit
