#pragma once

#include <algorithm>
#include <chrono>

namespace surfit::tools {

// When it is time to draw again: not more often than every min_gap_s, and so seldom that drawing
// takes no more than about a tenth of the time.
class Pace {
 public:
  explicit Pace(double min_gap_s) : min_gap_(min_gap_s) {}

  // Calls draw() if it is time, or if it must be.
  template <typename Draw>
  void DrawIfDue(bool must, const Draw& draw) {
    const Clock::time_point begin = Clock::now();
    if (!must && begin < next_) return;
    draw();
    const Clock::time_point end = Clock::now();
    constexpr int kGapPerDrawing = 9;
    next_ = end + std::max(std::chrono::duration_cast<Clock::duration>(min_gap_),
                           kGapPerDrawing * (end - begin));
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::chrono::duration<double> min_gap_;
  Clock::time_point next_;
};

}  // namespace surfit::tools
