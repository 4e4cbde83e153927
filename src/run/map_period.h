#pragma once

namespace surfit {

// How many of the frames that a camera offers are fused: fewer while they come faster than they are
// done, so that none has to be dropped; as many as before when there is time for it again.
class MapPeriod {
 public:
  explicit MapPeriod(int given) : given_(given), period_(given) {}

  // SlamOptions::map_period for the next frame, which has waited so long to be taken.
  int For(double queued_ms);

  int longest() const { return longest_; }         // that has been
  int frames_hurried() const { return hurried_; }  // with a longer one than was given

 private:
  void Change(int period);

  int given_, period_;
  int longest_ = 0, hurried_ = 0;
  int since_change_ = 0;      // frames
  double queued_ms_ = 0;      // what frames waited when the period was made longer
  int late_ = 0;              // frames in a row
  int in_time_ = 0;           // frames that were, less those that were not
  int patience_ = kInTime;    // so many of them make the period shorter
  bool was_shorter_ = false;  // by the last change
  static constexpr int kInTime = 90;
};

}  // namespace surfit
