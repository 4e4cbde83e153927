#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "simulation/random.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// Smooth random function in [-1, 1]: three sines with random frequency and phase.
class SmoothNoise {
 public:
  // Frequencies are in cycles per unit of the argument of At(). The smooth function is fixed at
  // construction.
  SmoothNoise(double lowest_frequency, double highest_frequency, Random* random) {
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

// Three independent functions SmoothNoise.
class SmoothNoise3 {
 public:
  SmoothNoise3(double lowest_frequency, double highest_frequency, Random* random)
      : x_(lowest_frequency, highest_frequency, random),
        y_(lowest_frequency, highest_frequency, random),
        z_(lowest_frequency, highest_frequency, random) {}
  Eigen::Vector3d At(double x) const { return {x_.At(x), y_.At(x), z_.At(x)}; }

 private:
  SmoothNoise x_, y_, z_;
};

// Speed variation and hand tremor, per frame. The total speed is within [low, high]: 70 % of the
// half range is speed variation, 30 % is tremor. A tremor of frequency f and amplitude a has a
// speed of at most 2 pi f a per axis. Units are those of `low` and `high`: for example m or rad per
// frame.
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

  // Speed without tremor, and displacement by the tremor, at a frame.
  double SpeedAt(int frame) const { return middle_ + swing_ * speed_.At(frame / fps_); }
  Eigen::Vector3d TrembleAt(int frame) const { return amplitude_ * tremble_.At(frame / fps_); }

 private:
  static constexpr double kShareOfSpeed = 0.7;
  static constexpr double kFastest_hz = 4;

  double middle_, swing_, fps_, amplitude_;
  SmoothNoise speed_;
  SmoothNoise3 tremble_;
};

// Closed Catmull-Rom spline.
class Loop {
 public:
  // Requires at least one corner.
  explicit Loop(std::vector<Eigen::Vector3d> corners) : corners_(std::move(corners)) {}

  // Point of the curve at the parameter `place`. At(i) is corner i. Periodic.
  Eigen::Vector3d At(double place) const {
    const double whole = std::floor(place), s = place - whole;
    const Eigen::Vector3d a = Corner(whole - 1), b = Corner(whole), c = Corner(whole + 1),
                          d = Corner(whole + 2);
    return 0.5 *
           (2 * b + s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * b - a - 3 * c + d))));
  }

 private:
  Eigen::Vector3d Corner(double index) const {
    const auto count = static_cast<double>(corners_.size());
    return corners_[static_cast<std::size_t>(index - count * std::floor(index / count))];
  }

  std::vector<Eigen::Vector3d> corners_;
};

// Random walk in the camera space of a scene, or along its route with small deviations.
class Walk {
 public:
  Walk(const Scene& scene, Random* random)
      : center_(scene.camera_space.center()),
        half_(scene.camera_space.sizes() / 2),
        curve_(0.05, 0.16, random) {
    if (scene.route.empty()) return;
    loop_.emplace(scene.route);
    half_ = {0.1, 0.1, 0.15};
  }

  // Current position in the world frame, m.
  Eigen::Vector3d Position() const { return At(place_); }

  // Advances to the next point of the curve at a straight distance of `step_m`. Requires step_m
  // below the extent of the walk, or it does not end.
  void Advance(double step_m) {
    const Eigen::Vector3d from = Position();
    const auto too_near = [&](double place) { return (At(place) - from).norm() < step_m; };
    double low = place_, stride = 1e-3;
    while (too_near(low + stride)) low += stride;
    for (int i = 0; i < 40; ++i) {
      stride /= 2;
      if (too_near(low + stride)) low += stride;
    }
    place_ = low + stride;
  }

 private:
  Eigen::Vector3d At(double place) const {
    return (loop_ ? loop_->At(place) : center_) + half_.cwiseProduct(curve_.At(place));
  }

  std::optional<Loop> loop_;
  Eigen::Vector3d center_, half_;
  SmoothNoise3 curve_;
  double place_ = 0;
};

}  // namespace surfit
