#include "run/map_period.h"

#include <algorithm>

namespace surfit {

int MapPeriod::For(double queued_ms) {
  // Of a camera's gaps two and one: of eight frames that may wait two do. After a frame that is
  // fused the next one may wait a little.
  constexpr double kLate_ms = 67, kInTime_ms = 33;
  constexpr int kMostTimes = 8;  // as long as given: beyond it little is gained
  // Frames that a change takes to show, and those in which what waits should have been done.
  constexpr int kUntilSeen = 4, kUntilDone = 30;
  // After a frame that takes long by itself, as one that moves the map, two or three are late, and
  // it counts as much as so many in time.
  constexpr int kLateInARow = 3, kOneLate = 5;
  constexpr int kMostPatience = 16 * kInTime;
  ++since_change_;
  late_ = queued_ms > kLate_ms ? late_ + 1 : 0;
  in_time_ = queued_ms < kInTime_ms ? in_time_ + 1 : std::max(0, in_time_ - kOneLate);
  const bool helps_not = since_change_ > (queued_ms > queued_ms_ ? kUntilSeen : kUntilDone);
  if (late_ >= kLateInARow && helps_not && period_ < kMostTimes * given_) {
    // Where there was too little time for what was taken up again, that is tried later next time.
    if (was_shorter_ && since_change_ < patience_) {
      patience_ = std::min(2 * patience_, kMostPatience);
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
