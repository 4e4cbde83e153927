#pragma once

namespace surfit {

// Adapts SlamOptions::map_period to the load. The period is doubled if frames arrive too fast, so
// that no frame is dropped. It is halved when there is time again. The limits are the given period
// and 8 times this period. Not thread-safe.
class MapPeriod {
 public:
  // `given`: period in frames, at least 1.
  explicit MapPeriod(int given) : given_(given), period_(given) {}

  // Returns the period for the next frame. Call once per frame. `queued_ms`: time of this frame in
  // the queue.
  int For(double queued_ms);

  // Longest returned period; 0 before the first call. Number of frames with a period above the
  // given one.
  int longest() const { return longest_; }
  int frames_with_longer_map_period() const { return hurried_; }

 private:
  void Change(int period);

  int given_, period_;
  int longest_ = 0, hurried_ = 0;
  int since_change_ = 0;
  double queued_ms_ = 0;  // queue time of the frame that doubled the period; 0: after halving
  int late_ = 0;          // consecutive late frames
  int in_time_ = 0;  // frames in time, minus kOneLate per frame that is not in time; at least 0
  int patience_ = kInTime;    // number of frames in time that halves the period
  bool was_shorter_ = false;  // the last change halved the period
  static constexpr int kInTime = 90;
};

}  // namespace surfit
