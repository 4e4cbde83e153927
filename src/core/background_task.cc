#include "core/background_task.h"

#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/low_priority_loops.h"

namespace surfit {

struct LowPriorityScope::State {
  bool is_awaited = false;
};

namespace {

thread_local bool is_least_thread = false;
thread_local const bool* is_task_awaited = nullptr;

struct Loop {
  const std::function<void(int)>& run_block;
  const int block_count;
  const bool& is_awaited;
  int next = 0;
  int running = 0;
  std::exception_ptr error;

  bool HasMore() const { return next < block_count; }
  bool IsDone() const { return !HasMore() && running == 0; }
};

// All tasks share this thread, which ends with the process.
class LowPriorityThread {
 public:
  LowPriorityThread() : thread_([this] { Work(); }) { thread_.detach(); }

  // Runs a loop on the thread and waits for its end. Returns false at once if Await() was already
  // called for the task. After a call of Await() during the loop, the thread that called Run() runs
  // the remaining blocks.
  bool Run(Loop* loop) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (loop->is_awaited) return false;
    loops_.push_back(loop);
    changed_.notify_all();
    changed_.wait(lock, [&] { return loop->IsDone() || loop->is_awaited; });
    while (loop->HasMore()) RunBlock(loop, &lock);
    changed_.wait(lock, [&] { return loop->IsDone(); });
    loops_.erase(std::find(loops_.begin(), loops_.end(), loop));
    if (loop->error) std::rethrow_exception(loop->error);
    return true;
  }

  void Await(bool* is_awaited) {
    const std::lock_guard<std::mutex> lock(mutex_);
    *is_awaited = true;
    changed_.notify_all();
  }

 private:
  [[noreturn]] void Work() {
#ifdef __linux__
    constexpr int kThisThread = 0, kMinPriority = 19;
    setpriority(PRIO_PROCESS, kThisThread, kMinPriority);  // Linux: only this thread
#endif
    is_least_thread = true;
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      const auto loop = std::find_if(loops_.begin(), loops_.end(),
                                     [](const Loop* l) { return l->HasMore() && !l->is_awaited; });
      if (loop == loops_.end()) {
        changed_.wait(lock);
      } else {
        RunBlock(*loop, &lock);
      }
    }
  }

  void RunBlock(Loop* loop, std::unique_lock<std::mutex>* lock) {
    const int block = loop->next++;
    ++loop->running;
    lock->unlock();
    std::exception_ptr error;
    try {
      loop->run_block(block);
    } catch (...) {
      error = std::current_exception();
    }
    lock->lock();
    --loop->running;
    if (error) {
      loop->error = error;
      loop->next = loop->block_count;
    }
    if (loop->IsDone()) changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Loop*> loops_;
  std::thread thread_;  // last member: the thread function uses all other members
};

LowPriorityThread& SharedLowPriorityThread() {
  static auto* const thread = new LowPriorityThread;
  return *thread;
}

}  // namespace

LowPriorityScope::LowPriorityScope() : state_(std::make_unique<State>()) {}

LowPriorityScope::~LowPriorityScope() = default;

void LowPriorityScope::Run(const std::function<void()>& task) {
  struct AtTask {
    explicit AtTask(const bool* is_awaited) { is_task_awaited = is_awaited; }
    ~AtTask() { is_task_awaited = nullptr; }
  };
  const AtTask at_task(&state_->is_awaited);
  task();
}

void LowPriorityScope::Await() { SharedLowPriorityThread().Await(&state_->is_awaited); }

bool RunLoopAtLowPriority(int block_count, const std::function<void(int)>& run_block) {
  if (is_least_thread) {
    for (int block = 0; block < block_count; ++block) run_block(block);
    return true;
  }
  if (is_task_awaited == nullptr) return false;
  Loop loop = {run_block, block_count, *is_task_awaited, 0, 0, {}};
  return SharedLowPriorityThread().Run(&loop);
}

}  // namespace surfit
