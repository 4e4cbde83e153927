#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace surfit {

class TraceFile;

// While one of these lives, all slices of the process go to a file that ui.perfetto.dev and
// chrome://tracing show: an array of trace events (docs: "Trace Event Format", complete events),
// one a line, in microseconds since the recorder was made. Slices of other threads must not
// outlive it. Without a recorder a slice costs one load.
class TraceRecorder {
 public:
  // Throws InputError if the file cannot be written; CHECK-fails if there is another recorder.
  explicit TraceRecorder(const std::string& path);
  ~TraceRecorder();
  TraceRecorder& operator=(TraceRecorder&&) = delete;

  // Ends the file; slices that end later are not recorded. Throws InputError if it is not whole.
  void Close();

 private:
  std::unique_ptr<TraceFile> file_;
};

// The time of its life, as a slice of its thread.
class TraceSlice {
 public:
  static constexpr int kNoFrame = -1;

  // The name is kept as a pointer and written as it is: a literal without quotes.
  explicit TraceSlice(const char* name, int frame = kNoFrame);
  ~TraceSlice();
  TraceSlice& operator=(TraceSlice&&) = delete;

 private:
  TraceFile* file_;  // null where nothing records
  const char* name_;
  int frame_;
  std::chrono::steady_clock::time_point begin_;
};

// A slice whose time is also added to a sum, recorded or not.
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
