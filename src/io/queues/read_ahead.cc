#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <utility>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

struct Item {
  std::optional<ReadResult> result;
  std::exception_ptr exception;
};

// A background task reads frames until the queue is full or the sequence ends. Next() starts the
// task again when the queue has space, so that no worker thread waits. With one thread, Next()
// reads the frame itself. Only one thread at a time uses the source.
class ReadAheadSource : public FrameSource {
 public:
  ReadAheadSource(std::unique_ptr<FrameSource> source, int capacity)
      : source_(std::move(source)), capacity_(static_cast<std::size_t>(capacity)) {}

  ~ReadAheadSource() override {
    std::unique_lock<std::mutex> lock(mutex_);
    stop_ = true;
    changed_.wait(lock, [&] { return !producing_; });
  }

  const SequenceInfo& info() const override { return source_->info(); }

  std::optional<ReadResult> Next() override {
    std::unique_lock<std::mutex> lock(mutex_);
    StartProducerIfIdle();
    if (queue_.empty() && !producing_ && !ended_) ReadOne(&lock);
    changed_.wait(lock, [&] { return !queue_.empty() || ended_; });
    if (queue_.empty() && failure_) std::rethrow_exception(failure_);
    if (queue_.empty()) return std::nullopt;
    Item item = std::move(queue_.front());
    queue_.pop_front();
    StartProducerIfIdle();
    if (item.exception) std::rethrow_exception(item.exception);
    return std::move(item.result);
  }

 private:
  bool MayRead() const { return !stop_ && !ended_ && queue_.size() < capacity_; }

  void StartProducerIfIdle() {
    if (producing_ || !MayRead() || ThreadCount() == 1) return;
    producing_ = true;
    RunInBackground([this] { Produce(); });
  }

  void Produce() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (MayRead()) {
      ReadOne(&lock);
      changed_.notify_all();
    }
    producing_ = false;
    changed_.notify_all();  // notified under the lock: afterwards, the object may be destroyed
  }

  // Reads one frame with the lock released, then adds it to the queue.
  void ReadOne(std::unique_lock<std::mutex>* lock) {
    lock->unlock();
    Item item;
    try {
      item.result = source_->Next();
    } catch (...) {
      item.exception = std::current_exception();
    }
    lock->lock();
    ended_ = !item.result;
    try {
      if (item.result || item.exception) queue_.push_back(std::move(item));
    } catch (...) {  // out of memory
      ended_ = true;
      failure_ = std::current_exception();
    }
  }

  const std::unique_ptr<FrameSource> source_;
  const std::size_t capacity_;

  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<Item> queue_;
  bool producing_ = false;  // a background task is running
  bool ended_ = false;
  bool stop_ = false;
  std::exception_ptr failure_;  // error of adding to the queue
};

}  // namespace

std::unique_ptr<FrameSource> ReadAhead(std::unique_ptr<FrameSource> source, int capacity) {
  ThrowIf(capacity < 1, "read-ahead capacity is ", capacity, ", must be at least 1");
  return std::make_unique<ReadAheadSource>(std::move(source), capacity);
}

}  // namespace surfit
