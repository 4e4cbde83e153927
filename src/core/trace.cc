#include "core/trace.h"

#include <glog/logging.h>

#include <atomic>
#include <cstdio>
#include <exception>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {

class TraceFile {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TraceFile(const std::string& path) : file_(path), start_(Clock::now()) {
    text_ << '[';
    ThreadNumber();
    Write();
  }

  void Add(const char* name, int frame, Clock::time_point begin, Clock::time_point end) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (closed_) return;
    const int thread = ThreadNumber();
    text_ << ",\n"
          << R"({"name":")" << name << R"(","ph":"X","pid":1,"tid":)" << thread << R"(,"ts":)"
          << Microseconds(begin - start_) << R"(,"dur":)" << Microseconds(end - begin);
    if (frame != TraceSlice::kNoFrame) text_ << R"(,"args":{"frame":)" << frame << '}';
    text_ << '}';
    if (text_.tellp() > kPiece) WriteUnlessItFailed();
  }

  void Close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (closed_) return;
    closed_ = true;
    if (failure_) std::rethrow_exception(failure_);
    text_ << "\n]\n";
    Write();
  }

 private:
  static constexpr std::streamoff kPiece = 1 << 16;  // bytes

  void Write() {
    file_.Append(text_.str());
    text_.str("");
  }

  // Write errors do not stop the program. Close() throws the first error.
  void WriteUnlessItFailed() {
    try {
      if (!failure_) Write();
    } catch (const InputError&) {
      failure_ = std::current_exception();
    }
    text_.str("");
  }

  // Text in microseconds with nanosecond resolution. Coarser times could break the nesting of
  // slices.
  static std::string Microseconds(Clock::duration duration) {
    const long long ns = std::chrono::nanoseconds(duration).count();
    char text[40];
    std::snprintf(text, sizeof(text), "%lld.%03lld", ns / 1000, ns % 1000);
    return text;
  }

  // Number of the calling thread, from 1 in the order of first use.
  int ThreadNumber() {
    const auto [thread, is_new] =
        threads_.emplace(std::this_thread::get_id(), static_cast<int>(threads_.size()) + 1);
    const int number = thread->second;
    if (is_new) {
      text_ << (number == 1 ? "\n" : ",\n") << R"({"name":"thread_name","ph":"M","pid":1,"tid":)"
            << number << R"(,"args":{"name":")"
            << (number == 1 ? std::string("main") : Concat("worker ", number - 1)) << R"("}})";
    }
    return number;
  }

  std::mutex mutex_;
  AppendedFile file_;
  std::ostringstream text_;  // text that is not yet written
  std::exception_ptr failure_;
  const Clock::time_point start_;
  std::map<std::thread::id, int> threads_;
  bool closed_ = false;
};

namespace {

std::atomic<TraceFile*> active{nullptr};

}  // namespace

TraceRecorder::TraceRecorder(const std::string& path) : file_(std::make_unique<TraceFile>(path)) {
  CHECK(active.exchange(file_.get()) == nullptr) << "another TraceRecorder exists";
}

TraceRecorder::~TraceRecorder() {
  active = nullptr;
  try {
    file_->Close();
  } catch (const InputError& error) {
    LOG(WARNING) << error.what();
  }
}

void TraceRecorder::Close() { file_->Close(); }

TraceSlice::TraceSlice(const char* name, int frame)
    : file_(active.load(std::memory_order_acquire)), name_(name), frame_(frame) {
  if (file_ != nullptr) begin_ = std::chrono::steady_clock::now();
}

TraceSlice::~TraceSlice() {
  if (file_ != nullptr) file_->Add(name_, frame_, begin_, std::chrono::steady_clock::now());
}

}  // namespace surfit
