#pragma once

#include <chrono>
#include <future>
#include <utility>
#include <vector>

#include "slam/loop_closer.h"
#include "surfit/core/parallel.h"

namespace surfit {

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
