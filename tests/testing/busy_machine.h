#pragma once

#include <algorithm>
#include <atomic>
#include <ctime>
#include <thread>
#include <vector>

namespace surfit::testing {

// Busy loop on this thread for this CPU time.
inline void Compute(double milliseconds) {
  const auto now_ms = [] {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  };
  const double end_ms = now_ms() + milliseconds;
  while (now_ms() < end_ms) {
  }
}

// Keeps all cores busy with two threads per core.
class BusyMachine {
 public:
  BusyMachine() {
    for (unsigned i = 0; i < 2 * std::max(1u, std::thread::hardware_concurrency()); ++i) {
      threads_.emplace_back([this] {
        while (!end_) Compute(1);
      });
    }
  }
  ~BusyMachine() {
    end_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> end_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace surfit::testing
