#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {

// Runs the parallel loops of a task (ParallelFor()) on one thread of low priority. All scopes of
// the process share this thread. It has the lowest priority on Linux, and the normal priority on
// other systems. Code between the loops runs on the thread of the task, which keeps its priority.
// So a thread that calls Await() waits for at most one block of a loop at low priority.
class LowPriorityScope {
 public:
  LowPriorityScope();
  ~LowPriorityScope();
  LowPriorityScope& operator=(LowPriorityScope&&) = delete;

  // Runs the task on the calling thread. Exceptions of the task and of its loops propagate. The
  // scope must outlive the call. A task must not call Run() of another scope.
  void Run(const std::function<void()>& task);
  // Ends the low priority permanently, because a thread waits for the task. Does not wait. The
  // thread of the task runs the remaining blocks of the current loop. Later loops run on all
  // threads of ParallelFor(). Thread-safe, before, during and after Run().
  void Await();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

// Asynchronous task with low-priority loops. At most one task is pending. All functions must be
// called by one thread. Result must be default-constructible. If ThreadCount() is 1 at Start(), the
// task runs in Wait() or Take() without low priority, unless `always_in_background` is true. The
// result is due after a fixed number of steps. With IsDueAfterStep(), results do not depend on the
// machine. The destructor calls Drop().
template <typename Result>
class BackgroundTask {
 public:
  explicit BackgroundTask(bool always_in_background = false)
      : always_in_background_(always_in_background) {}
  ~BackgroundTask() { Drop(); }
  BackgroundTask& operator=(BackgroundTask&&) = delete;

  // Starts a task that returns a Result. `due_after_steps` is a number of calls of IsDueAfterStep()
  // or IsReadyAfterStep(). Objects that the task refers to must live until Take() or Drop()
  // returns. Requires that no task is pending, which is not checked.
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
  // Counts a step. Returns true if a result is due, also if the task is still running. False
  // without a pending task.
  bool IsDueAfterStep() { return IsPending() && --steps_left_ <= 0; }
  // Counts a step. Returns true if a result is due and ready, which depends on the machine. Ends
  // the low priority of a task that is due and still running.
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
  // Ends the low priority of the task and waits for it, without throwing its exceptions. Returns at
  // once if no task is pending.
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
  // Discards the result and exceptions of the task. Waits for a running task. A task that would run
  // in Wait() or Take() does not run.
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
