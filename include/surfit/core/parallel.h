#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace surfit {

// Limits the number of threads that compute at the same time in this process, including the calling
// thread. The limit applies to ParallelFor() and RunInBackground() during the lifetime of the
// object. The smallest of several limits applies. OpenCV uses one thread under a limit. The end of
// the last limit restores the former number of OpenCV threads. Threads that the program starts
// itself are not counted, for example those of loop closure and calibration.
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

// Maximum number of threads that compute at the same time under the present limits.
int ThreadCount();

// Number of image rows per block of a parallel loop.
inline constexpr int kRowsPerBlock = 16;

// Calls body(block_begin, block_end) for the blocks [begin + k * grain, ...) that cover [begin,
// end). The blocks do not depend on the number of threads. They may run in parallel and in any
// order. Returns when all blocks are done. Rethrows an exception of a block; later blocks may not
// run then. Aborts if grain <= 0.
void ParallelFor(int begin, int end, int grain, const std::function<void(int, int)>& body);

// Sum of body(block_begin, block_end) over the blocks of ParallelFor(). The values are added in
// block order, so the sum is bitwise identical for every number of threads.
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

// Runs the task on another thread within the limit, and returns immediately. Aborts if
// ThreadCount() is 1. The task must not throw.
void RunInBackground(std::function<void()> task);

// Limits OpenMP and OpenBLAS to one thread during the lifetime of the object, so that their sums do
// not depend on the machine. The OpenMP limit applies to loops of the calling thread, for example
// of CHOLMOD. The OpenBLAS limit applies to the process. Libraries that are not loaded are ignored.
class SingleThreadedLibraries {
 public:
  SingleThreadedLibraries();
  ~SingleThreadedLibraries();
  SingleThreadedLibraries& operator=(SingleThreadedLibraries&&) = delete;

 private:
  int openmp_threads_, openblas_threads_;  // former number of threads; 0: not loaded
};

}  // namespace surfit
