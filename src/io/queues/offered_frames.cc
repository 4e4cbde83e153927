#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "core/repeated_warning.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point then) {
  return std::chrono::duration<double, std::milli>(Clock::now() - then).count();
}

class OfferedFrames final : public FrameSource {
 public:
  OfferedFrames(std::unique_ptr<FrameSource> source, double frames_per_second, int capacity)
      : source_(std::move(source)),
        period_s_(1 / frames_per_second),
        capacity_(static_cast<std::size_t>(capacity)) {}

  const SequenceInfo& info() const override { return source_->info(); }

  std::optional<ReadResult> Next() override {
    const Clock::time_point asked = Clock::now();
    if (!is_read_) ReadAll();
    const int dropped = DropOldFrames();
    if (next_ == frames_.size()) return std::nullopt;
    const Clock::time_point offered = TimeOf(next_);
    std::this_thread::sleep_until(offered);
    ReadResult result = std::move(frames_[next_++]);
    result.dropped_before = dropped;
    result.waited_ms = offered > asked ? MillisecondsSince(asked) : 0;
    result.queued_ms = MillisecondsSince(offered);
    return result;
  }

 private:
  void ReadAll() {
    while (auto result = source_->Next()) frames_.push_back(std::move(*result));
    is_read_ = true;
    start_ = Clock::now();
  }

  Clock::time_point TimeOf(std::size_t frame) const {
    const std::chrono::duration<double> since_start(static_cast<double>(frame) * period_s_);
    return start_ + std::chrono::duration_cast<Clock::duration>(since_start);
  }

  // Drops a waiting frame if at least `capacity` later frames have already been offered. Returns
  // the number of dropped frames.
  int DropOldFrames() {
    int dropped = 0;
    while (next_ + capacity_ < frames_.size() && TimeOf(next_ + capacity_) < Clock::now()) {
      late_.Tell(Concat("frame ", frames_[next_].index, " was dropped: processing is too slow"));
      frames_[next_++].frame.reset();
      ++dropped;
    }
    return dropped;
  }

  const std::unique_ptr<FrameSource> source_;
  const double period_s_;
  const std::size_t capacity_;
  std::vector<ReadResult> frames_;
  bool is_read_ = false;
  Clock::time_point start_;  // time of the first frame
  std::size_t next_ = 0;     // index of frames_
  RepeatedWarning late_{"frames dropped"};
};

}  // namespace

std::unique_ptr<FrameSource> OfferFrames(std::unique_ptr<FrameSource> source,
                                         double frames_per_second, int capacity) {
  ThrowIf(!(frames_per_second > 0), "frames_per_second is ", frames_per_second,
          ", must be positive");
  ThrowIf(capacity < 1, "the capacity for offered frames is ", capacity, ", must be at least 1");
  return std::make_unique<OfferedFrames>(std::move(source), frames_per_second, capacity);
}

}  // namespace surfit
