#include "surfit/core/parallel.h"

#include <glog/logging.h>
#include <sys/resource.h>
#include <tbb/concurrent_queue.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "core/thread_sanitizer.h"
#include "surfit/core/error.h"

namespace surfit {

struct ThreadLimit::State {
  explicit State(int threads)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads) {
  if (threads < 1 || threads > 1024) {
    throw InputError(Concat("threads is ", threads, ", must be from 1 to 1024"));
  }
  // OpenCV only decodes and draws for us; its own loops would add threads beside ours.
  cv::setNumThreads(1);
  state_ = std::make_unique<State>(threads);
}

ThreadLimit::~ThreadLimit() = default;

int ThreadCount() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void ParallelFor(int begin, int end, int grain, const std::function<void(int, int)>& body) {
  CHECK_GT(grain, 0);
  if (end <= begin) return;
  const int blocks = (end - begin + grain - 1) / grain;
  const auto run_block = [&](int block) {
    const int block_begin = begin + block * grain;
    body(block_begin, std::min(end, block_begin + grain));
  };
  if (blocks == 1 || ThreadCount() == 1) {
    for (int block = 0; block < blocks; ++block) run_block(block);
    return;
  }
  static SanitizerFence fork, join;
  const auto run_fenced_block = [&](int block) {
    fork.Acquire();
    run_block(block);
    join.Release();
  };
  fork.Release();
  tbb::parallel_for(0, blocks, run_fenced_block);
  join.Acquire();
}

void RunInSpareTime(const std::function<void()>& task) {
#ifdef __linux__
  constexpr int kThisThread = 0, kLeastPriority = 19;
  setpriority(PRIO_PROCESS, kThisThread, kLeastPriority);  // on Linux a thread has its own
#endif
  tbb::task_arena alone(1);
  alone.execute(task);
}

namespace {

// Carries the tasks of RunInBackground; the arena only gets word that there is one more. Unlike the
// arena's, its order is visible to ThreadSanitizer.
tbb::concurrent_queue<std::function<void()>>& BackgroundTasks() {
  static auto* const tasks = new tbb::concurrent_queue<std::function<void()>>;
  return *tasks;
}

}  // namespace

void RunInBackground(std::function<void()> task) {
  CHECK_GT(ThreadCount(), 1) << "a background task needs a second thread";
  // Isolated from the caller's arena, so that a waiting parallel loop never picks the task up.
  static tbb::task_arena* const arena = new tbb::task_arena(2, 1);
  BackgroundTasks().push(std::move(task));
  arena->enqueue([] {
    std::function<void()> next;
    CHECK(BackgroundTasks().try_pop(next));
    next();
  });
}

}  // namespace surfit
