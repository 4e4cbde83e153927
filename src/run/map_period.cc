#include "run/map_period.h"

#include <algorithm>

namespace surfit {

int MapPeriod::For(double queued_ms) {
  // Limits of the waiting time of a frame. At 30 Hz, two frames take 67 ms and one frame takes 33
  // ms.
  constexpr double kLate_ms = 67, kInTime_ms = 33;
  constexpr int kMaxTimes = 8;  // maximum period / given_; longer periods save little time
  // Minimum number of frames between a change of the period and the next doubling. kUntilSeen: the
  // queue time has increased. kUntilDone: otherwise.
  constexpr int kUntilSeen = 4, kUntilDone = 30;
  // kLateInARow consecutive late frames double the period. A frame above kInTime_ms subtracts
  // kOneLate from in_time_.
  constexpr int kLateInARow = 3, kOneLate = 5;
  constexpr int kMaxPatience = 16 * kInTime;
  ++since_change_;
  late_ = queued_ms > kLate_ms ? late_ + 1 : 0;
  in_time_ = queued_ms < kInTime_ms ? in_time_ + 1 : std::max(0, in_time_ - kOneLate);
  const bool helps_not = since_change_ > (queued_ms > queued_ms_ ? kUntilSeen : kUntilDone);
  if (late_ >= kLateInARow && helps_not && period_ < kMaxTimes * given_) {
    // the period was halved too early: doubles the wait until the next attempt
    if (was_shorter_ && since_change_ < patience_) {
      patience_ = std::min(2 * patience_, kMaxPatience);
    }
    Change(2 * period_);
    queued_ms_ = queued_ms;
  } else if (in_time_ >= patience_ && period_ > given_) {
    Change(std::max(given_, period_ / 2));
    queued_ms_ = 0;
  }
  longest_ = std::max(longest_, period_);
  if (period_ > given_) ++hurried_;
  return period_;
}

void MapPeriod::Change(int period) {
  was_shorter_ = period < period_;
  period_ = period;
  since_change_ = in_time_ = 0;
}

}  // namespace surfit
