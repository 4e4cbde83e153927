#pragma once

namespace surfit {

// Adapts SlamOptions::map_period to the load. The period doubles while frames arrive faster than
// they are processed, so that no frame has to be dropped. It is halved when there is time again.
class MapPeriod {
 public:
  // `given` is the minimum period.
  explicit MapPeriod(int given) : given_(given), period_(given) {}

  // Returns the period for the next frame, which has waited `queued_ms` in the queue. Call it once
  // per frame.
  int For(double queued_ms);

  int longest() const { return longest_; }
  int frames_with_longer_map_period() const {
    return hurried_;
  }  // frames with more than the minimum period

 private:
  void Change(int period);

  int given_, period_;
  int longest_ = 0, hurried_ = 0;
  int since_change_ = 0;      // frames since the last change
  double queued_ms_ = 0;      // wait of the frame that doubled the period; 0: after halving
  int late_ = 0;              // consecutive late frames
  int in_time_ = 0;           // frames in time, minus kOneLate per slower frame; at least 0
  int patience_ = kInTime;    // value of in_time_ that halves the period
  bool was_shorter_ = false;  // the last change halved the period
  static constexpr int kInTime = 90;
};

}  // namespace surfit
