#include "surfit/core/parallel.h"

#include <dlfcn.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "core/low_priority_loops.h"
#include "surfit/core/error.h"

#if defined(SURFIT_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace surfit {

namespace {

// ThreadSanitizer does not see the synchronisation of the prebuilt oneTBB, which is not
// instrumented. A fence reports this synchronisation to ThreadSanitizer. The fence is empty in
// other builds.
class SanitizerFence {
 public:
#if defined(SURFIT_THREAD_SANITIZER)
  void Release() { __tsan_release(this); }
  void Acquire() { __tsan_acquire(this); }
#else
  void Release() {}
  void Acquire() {}
#endif

 private:
  [[maybe_unused]] char address_ = 0;
};

// Sets the number of threads of a library, and returns the previous number. Returns 0 if the
// library is not loaded.
int SetThreads(const char* getter, const char* setter, int count) {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, getter));
  const auto set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, setter));
  if (get == nullptr || set == nullptr) return 0;
  const int former = get();
  set(count);
  return former;
}

int SetOpenMpThreads(int count) {
  return SetThreads("omp_get_max_threads", "omp_set_num_threads", count);
}

int SetOpenBlasThreads(int count) {
  return SetThreads("openblas_get_num_threads", "openblas_set_num_threads", count);
}

}  // namespace

struct ThreadLimit::State {
  // OpenCV uses one thread while at least one limit exists, because its own threads would exceed
  // the limit. The last limit restores the former number.
  struct OneOpenCvThread {
    OneOpenCvThread() {
      const std::lock_guard<std::mutex> lock(mutex);
      if (limits++ > 0) return;
      former_threads = cv::getNumThreads();
      cv::setNumThreads(1);
    }
    ~OneOpenCvThread() {
      const std::lock_guard<std::mutex> lock(mutex);
      if (--limits == 0) cv::setNumThreads(former_threads);
    }
    OneOpenCvThread& operator=(OneOpenCvThread&&) = delete;

    static inline std::mutex mutex;
    static inline int limits = 0, former_threads = 0;
  };

  explicit State(int threads)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}

  OneOpenCvThread opencv;  // reads the number of threads before the limit applies
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads) {
  ThrowIf(threads < 1 || threads > 1024, "threads is ", threads, ", must be from 1 to 1024");
  state_ = std::make_unique<State>(threads);
}

ThreadLimit::~ThreadLimit() = default;

int ThreadCount() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void ParallelFor(int begin, int end, int grain, const std::function<void(int, int)>& body) {
  ThrowIf(grain < 1, "grain is ", grain, ", must be at least 1");
  if (end <= begin) return;
  const int blocks = (end - begin + grain - 1) / grain;
  const auto run_block = [&](int block) {
    const int block_begin = begin + block * grain;
    body(block_begin, std::min(end, block_begin + grain));
  };
  if (blocks > 1 && RunLoopAtLowPriority(blocks, run_block)) return;
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

void RunInBackground(std::function<void()> task) {
  ThrowIf(ThreadCount() < 2, "background tasks need a limit of at least 2 threads");
  static tbb::task_arena* const arena = new tbb::task_arena(2, 1);
  static SanitizerFence fork;
  fork.Release();
  arena->enqueue([task = std::move(task)] {
    fork.Acquire();
    task();
  });
}

SingleThreadedLibraries::SingleThreadedLibraries()
    : openmp_threads_(SetOpenMpThreads(1)), openblas_threads_(SetOpenBlasThreads(1)) {}

SingleThreadedLibraries::~SingleThreadedLibraries() {
  if (openblas_threads_ > 0) SetOpenBlasThreads(openblas_threads_);
  if (openmp_threads_ > 0) SetOpenMpThreads(openmp_threads_);
}

}  // namespace surfit
