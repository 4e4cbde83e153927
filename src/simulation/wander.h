#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "simulation/random.h"

namespace surfit {

// A sum of sines of random phase: smooth, never repeating soon, in [-1, 1].
class Wander {
 public:
  Wander(double lowest_frequency, double highest_frequency, Random* random) {
    for (Wave& wave : waves_) {
      wave.frequency = random->Uniform(lowest_frequency, highest_frequency);
      wave.phase = random->Uniform(0, 2 * M_PI);
      wave.amplitude = random->Uniform(0.5, 1);
      sum_ += wave.amplitude;
    }
  }
  double At(double x) const {
    double value = 0;
    for (const Wave& wave : waves_) {
      value += wave.amplitude * std::sin(2 * M_PI * wave.frequency * x + wave.phase);
    }
    return value / sum_;
  }

 private:
  struct Wave {
    double frequency, phase, amplitude;
  };
  std::array<Wave, 3> waves_;
  double sum_ = 0;
};

class Wander3 {
 public:
  Wander3(double lowest_frequency, double highest_frequency, Random* random)
      : x_(lowest_frequency, highest_frequency, random),
        y_(lowest_frequency, highest_frequency, random),
        z_(lowest_frequency, highest_frequency, random) {}
  Eigen::Vector3d At(double x) const { return {x_.At(x), y_.At(x), z_.At(x)}; }

 private:
  Wander x_, y_, z_;
};

}  // namespace surfit
