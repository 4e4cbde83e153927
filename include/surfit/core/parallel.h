#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace surfit {

// Bounds the number of threads that compute at the same time in this process, the calling one
// included, for as long as the object lives: parallel loops, background tasks and OpenCV together.
// With nested limits the smallest holds.
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

// The number of threads that may compute at the same time now.
int ThreadCount();

// Rows of an image that are worth a task.
inline constexpr int kRowsPerBlock = 16;

// Calls body(block_begin, block_end) for the blocks [begin + k * grain, ...) that cover
// [begin, end). The blocks depend on grain alone, never on the number of threads; they may run at
// the same time and in any order. Returns when all are done.
void ParallelFor(int begin, int end, int grain, const std::function<void(int, int)>& body);

// Sums body(block_begin, block_end) over the blocks of ParallelFor in block order, so that the
// result is the same bit for bit at any number of threads.
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

// Runs the task on another thread of the bounded set, soon. Must not be called when ThreadCount()
// is 1: nothing would run it before the caller waits. The task must not throw.
void RunInBackground(std::function<void()> task);

// While it lives, OpenMP's loops that begin on this thread (CHOLMOD's) and OpenBLAS, where they are
// loaded, use one thread, so that sums have the same order on every machine. Debian's own BLAS
// has one anyway.
class SingleThreadedLibraries {
 public:
  SingleThreadedLibraries();
  ~SingleThreadedLibraries();
  SingleThreadedLibraries& operator=(SingleThreadedLibraries&&) = delete;

 private:
  int openmp_threads_, openblas_threads_;  // before; 0 where not loaded
};

}  // namespace surfit
