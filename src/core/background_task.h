#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {

// Runs the parallel loops of a task at low priority. On Linux, one thread of the lowest priority
// runs the blocks of the loops. The thread of the task keeps its priority. So a waiting thread
// waits for at most one block at low priority.
class LowPriorityScope {
 public:
  LowPriorityScope();
  ~LowPriorityScope();
  LowPriorityScope& operator=(LowPriorityScope&&) = delete;

  // Runs the task on the calling thread. Exceptions propagate.
  void Run(const std::function<void()>& task);
  // Ends the low priority, because a thread waits for the task. Thread-safe.
  void Await();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

// Asynchronous task with low-priority loops, one at a time. One thread calls all functions. Result
// must be default-constructible. With a thread limit of 1, the task runs in Wait() or Take(),
// unless `always_in_background` is true. The result is due after a fixed number of steps, so that
// it does not depend on the machine. The destructor waits for a running task.
template <typename Result>
class BackgroundTask {
 public:
  explicit BackgroundTask(bool always_in_background = false)
      : always_in_background_(always_in_background) {}
  ~BackgroundTask() { Drop(); }
  BackgroundTask& operator=(BackgroundTask&&) = delete;

  // Starts a task that returns a Result. `due_after_steps` is a number of calls of
  // IsDueAfterStep(). Requires that no task is pending.
  template <typename Task>
  void Start(int due_after_steps, Task task) {
    steps_left_ = due_after_steps;
    const bool is_beside = always_in_background_ || ThreadCount() > 1;
    spare_time_ = is_beside ? std::make_shared<LowPriorityScope>() : nullptr;
    const auto launch = spare_time_ ? std::launch::async : std::launch::deferred;
    result_ = std::async(launch, [spare_time = spare_time_, task = std::move(task)]() mutable {
      Result result;
      const auto run = [&] { result = task(); };
      spare_time ? spare_time->Run(run) : run();
      return result;
    });
  }

  // True from Start() until Take() or Drop().
  bool IsPending() const { return result_.valid(); }
  // Counts a step. Returns true if a result is due, also if the task is still running.
  bool IsDueAfterStep() { return IsPending() && --steps_left_ <= 0; }
  // Counts a step. Ends the low priority of an overdue task.
  bool IsReadyAfterStep() {
    if (!IsDueAfterStep()) return false;
    if (!IsAtWork()) return true;
    spare_time_->Await();
    return false;
  }
  // True if Take() does not wait for another thread.
  bool IsReady() const { return IsPending() && !IsAtWork(); }
  // True if another thread runs the task.
  bool IsAtWork() const {
    return IsPending() && result_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
  }
  // Waits for the task, without its low priority. Returns at once if no task is pending.
  void Wait() const {
    if (!IsPending()) return;
    if (spare_time_) spare_time_->Await();
    result_.wait();
  }
  // Waits for the result. Requires a pending task. Rethrows exceptions of the task.
  Result Take() {
    Wait();
    return result_.get();
  }
  // Discards the result. Waits for a running task.
  void Drop() {
    if (spare_time_) Wait();
    result_ = {};
  }

 private:
  bool always_in_background_;
  std::shared_ptr<LowPriorityScope> spare_time_;  // null for a lazy task
  std::future<Result> result_;
  int steps_left_ = 0;
};

}  // namespace surfit
