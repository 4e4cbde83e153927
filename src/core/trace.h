#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace surfit {

class TraceFile;

// Records all slices of the process to a file for ui.perfetto.dev and chrome://tracing ("Trace
// Event Format"). Times are in microseconds since construction. Slices may end in several threads
// at the same time. Slices must end before the destruction. Without a recorder, a slice costs one
// atomic load.
class TraceRecorder {
 public:
  // Throws InputError if the file cannot be written. Aborts if another recorder exists.
  explicit TraceRecorder(const std::string& path);
  ~TraceRecorder();
  TraceRecorder& operator=(TraceRecorder&&) = delete;

  // Completes the file. Slices that end later are not recorded. Throws InputError if a write has
  // failed; the destructor logs the error instead.
  void Close();

 private:
  std::unique_ptr<TraceFile> file_;
};

// Records its lifetime as a slice of the calling thread, with an optional frame index. Must be
// constructed and destroyed by one thread.
class TraceSlice {
 public:
  static constexpr int kNoFrame = -1;

  // `name`: a string literal without quotes, because the pointer is stored and written without
  // escaping.
  explicit TraceSlice(const char* name, int frame = kNoFrame);
  ~TraceSlice();
  TraceSlice& operator=(TraceSlice&&) = delete;

 private:
  TraceFile* file_;  // null: not recorded
  const char* name_;
  int frame_;
  std::chrono::steady_clock::time_point begin_;
};

// Records a slice, and adds its duration to `*sum_ms`, which must outlive this object.
class StageTimer {
 public:
  StageTimer(const char* name, int frame, double* sum_ms)
      : slice_(name, frame), sum_ms_(sum_ms), begin_(Clock::now()) {}
  ~StageTimer() {
    *sum_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
  }
  StageTimer& operator=(StageTimer&&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  TraceSlice slice_;
  double* sum_ms_;
  Clock::time_point begin_;
};

}  // namespace surfit
