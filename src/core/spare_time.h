#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {

// Spare time for a task on a thread of one's own beside the bounded set. The task keeps its
// thread's priority; the blocks of its parallel loops are done one after the other by a thread of
// least priority (on Linux), in time that no other thread wants, until somebody waits for the task:
// then the loops are as all others. So nobody waits for a thread of less priority than their own,
// but for one block at most.
class SpareTime {
 public:
  SpareTime();
  ~SpareTime();
  SpareTime& operator=(SpareTime&&) = delete;

  // Runs the task on the calling thread. What it throws is thrown on.
  void Run(const std::function<void()>& task);
  // From now on the task is waited for.
  void Await();

  struct State;

 private:
  std::unique_ptr<State> state_;
};

// A task on a thread of its own, one at a time, in spare time; where only one thread may compute,
// when its result is asked for, unless `always_beside`. The result is due after a number of steps
// of who began it, so that no machine has a say in when it takes effect. Going, it waits for the
// task.
template <typename Result>
class SpareTimeTask {
 public:
  explicit SpareTimeTask(bool always_beside = false) : always_beside_(always_beside) {}
  ~SpareTimeTask() { Drop(); }
  SpareTimeTask& operator=(SpareTimeTask&&) = delete;

  // None may be under way.
  template <typename Task>
  void Start(int due_after_steps, Task task) {
    steps_left_ = due_after_steps;
    const bool is_beside = always_beside_ || ThreadCount() > 1;
    spare_time_ = is_beside ? std::make_shared<SpareTime>() : nullptr;
    const auto launch = spare_time_ ? std::launch::async : std::launch::deferred;
    result_ = std::async(launch, [spare_time = spare_time_, task = std::move(task)]() mutable {
      Result result;
      const auto run = [&] { result = task(); };
      spare_time ? spare_time->Run(run) : run();
      return result;
    });
  }

  // A task was begun whose result has not been taken.
  bool IsUnderWay() const { return result_.valid(); }
  // Counts one step: whether there is a result that is due.
  bool IsDueAfterStep() { return IsUnderWay() && --steps_left_ <= 0; }
  // The same where nobody must wait: whether the result is there as well. What is late is done in
  // spare time no longer.
  bool IsThereAfterStep() {
    if (!IsDueAfterStep()) return false;
    if (!IsAtWork()) return true;
    spare_time_->Await();
    return false;
  }
  // Its result can be taken at once.
  bool IsThere() const { return IsUnderWay() && !IsAtWork(); }
  // Its result is to be waited for.
  bool IsAtWork() const {
    return IsUnderWay() && result_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
  }
  void Wait() const {
    if (!IsUnderWay()) return;
    if (spare_time_) spare_time_->Await();
    result_.wait();
  }
  // Waits for it; throws on what the task has thrown.
  Result Take() {
    Wait();
    return result_.get();
  }
  // Its result is not wanted any more: waits for it where it has a thread.
  void Drop() {
    if (spare_time_) Wait();
    result_ = {};
  }

 private:
  bool always_beside_;
  std::shared_ptr<SpareTime> spare_time_;  // null where the task has no thread
  std::future<Result> result_;
  int steps_left_ = 0;
};

}  // namespace surfit
