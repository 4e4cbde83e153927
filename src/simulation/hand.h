#pragma once

#include <Eigen/Core>
#include <cmath>

#include "simulation/random.h"
#include "simulation/wander.h"

namespace surfit {

// Slow variation of speed, and the trembling of a hand. Speeds take the middle of the bounds; the
// rest is for the tremble, whose speed at frequency f and amplitude a is at most 2 pi f a on each
// of three axes.
class Hand {
 public:
  Hand(double low, double high, double frames_per_second, Random* random)
      : middle_((low + high) / 2),
        swing_(kShareOfSpeed * (high - low) / 2),
        fps_(frames_per_second),
        amplitude_((1 - kShareOfSpeed) * (high - low) / 2 /
                   (std::sqrt(3.0) * 2 * M_PI * kFastest_hz / frames_per_second)),
        speed_(0.1, 0.5, random),
        tremble_(1, kFastest_hz, random) {}

  double SpeedAt(int frame) const { return middle_ + swing_ * speed_.At(frame / fps_); }
  Eigen::Vector3d TrembleAt(int frame) const { return amplitude_ * tremble_.At(frame / fps_); }

 private:
  static constexpr double kShareOfSpeed = 0.7;
  static constexpr double kFastest_hz = 4;

  double middle_, swing_, fps_, amplitude_;
  Wander speed_;
  Wander3 tremble_;
};

}  // namespace surfit
