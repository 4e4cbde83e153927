#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace surfit {

// Limits the number of computing threads of the process, including the calling thread. Applies to
// ParallelFor() and RunInBackground() during the lifetime of the object. The smallest of several
// limits applies. Without a limit, one thread per logical processor computes. Threads that the
// program starts itself are not counted. OpenCV uses one thread while a limit exists. Thread-safe.
class ThreadLimit {
 public:
  // Throws InputError unless 1 <= threads <= 1024.
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit& operator=(ThreadLimit&&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Maximum number of computing threads under the current limits.
int ThreadCount();

// Number of image rows per block of a parallel loop.
inline constexpr int kRowsPerBlock = 16;

// Calls body(block_begin, block_end) for the blocks [begin + k * grain, ...) that cover [begin,
// end). Blocks may run in parallel and in any order, but do not depend on the number of threads.
// Returns when all blocks are done; at once for an empty range. Rethrows the first exception of a
// block; other blocks may not run then. Calls may be nested, and several threads may call at the
// same time. A waiting thread may run blocks of other loops: do not hold a lock during the call.
// Throws if grain <= 0.
void ParallelFor(int begin, int end, int grain, const std::function<void(int, int)>& body);

// Sum of body(block_begin, block_end) over the blocks of ParallelFor(); `zero` for an empty range.
// Values are added in block order, so the sum is bitwise identical for any number of threads.
// Requires grain > 0.
template <typename T, typename Body>
T ParallelSum(int begin, int end, int grain, T zero, const Body& body) {
  if (end <= begin) return zero;
  std::vector<T> partial((end - begin + grain - 1) / grain, zero);
  ParallelFor(begin, end, grain, [&](int block_begin, int block_end) {
    partial[(block_begin - begin) / grain] = body(block_begin, block_end);
  });
  T sum = zero;
  for (const T& value : partial) sum += value;
  return sum;
}

// Runs the task on another thread within the limit. Returns immediately. Tasks run one at a time,
// each with its loops on one thread. Throws without a second thread (ThreadCount() == 1). The task
// must not throw. There is no function to wait for a task: the caller must keep its data alive and
// signal its end.
void RunInBackground(std::function<void()> task);

// Limits OpenMP and OpenBLAS to one thread during the lifetime of the object, so that sums do not
// depend on the machine. The OpenMP limit applies to the calling thread, which must also destroy
// the object. The OpenBLAS limit applies to the process. Libraries that are not loaded are ignored.
class SingleThreadedLibraries {
 public:
  SingleThreadedLibraries();
  ~SingleThreadedLibraries();
  SingleThreadedLibraries& operator=(SingleThreadedLibraries&&) = delete;

 private:
  int openmp_threads_, openblas_threads_;  // former number of threads; 0: not loaded
};

}  // namespace surfit
