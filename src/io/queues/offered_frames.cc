#include <chrono>
#include <thread>
#include <utility>

#include "core/repeated_warning.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point then) {
  return std::chrono::duration<double, std::milli>(Clock::now() - then).count();
}

// Number of frames that are decoded before they are due. Bounds the memory of long recordings.
constexpr int kAhead = 30;

class OfferedFrames final : public FrameSource {
 public:
  OfferedFrames(std::unique_ptr<FrameSource> source, double frames_per_second, int capacity)
      : source_(ReadAhead(std::move(source), kAhead)),
        period_s_(1 / frames_per_second),
        capacity_(capacity) {}

  const SequenceInfo& info() const override { return source_->info(); }

  std::optional<ReadResult> Next() override {
    const Clock::time_point asked = Clock::now();
    std::optional<ReadResult> result = source_->Next();
    if (next_ == 0) start_ = Clock::now();
    int dropped = 0;
    while (result && IsLate(next_)) {
      late_.Tell(Concat("frame ", result->index, " was dropped: processing is too slow"));
      result = source_->Next();
      ++next_;
      ++dropped;
    }
    if (!result) return std::nullopt;
    const Clock::time_point offered = TimeOf(next_++);
    std::this_thread::sleep_until(offered);
    result->dropped_before = dropped;
    result->waited_ms = offered > asked ? MillisecondsSince(asked) : 0;
    result->queued_ms = MillisecondsSince(offered);
    return result;
  }

 private:
  Clock::time_point TimeOf(int frame) const {
    const std::chrono::duration<double> since_start(frame * period_s_);
    return start_ + std::chrono::duration_cast<Clock::duration>(since_start);
  }

  // True for a frame with at least `capacity` later frames that are due.
  bool IsLate(int frame) const {
    const int count = info().frame_count, later = frame + capacity_;
    return (count < 0 || later < count) && TimeOf(later) < Clock::now();
  }

  const std::unique_ptr<FrameSource> source_;
  const double period_s_;
  const int capacity_;
  Clock::time_point start_;  // time of the first frame
  int next_ = 0;             // number of frames that were taken from the source
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
