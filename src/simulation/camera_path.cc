#include "surfit/simulation/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulation/random.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerDeg = M_PI / 180;

void Check(bool holds, const char* field, double value, const char* constraint) {
  if (!holds) throw InputError(Concat("PathOptions: ", field, " is ", value, ", ", constraint));
}

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
  Vector3d At(double x) const { return {x_.At(x), y_.At(x), z_.At(x)}; }

 private:
  Wander x_, y_, z_;
};

// Points at equal or slowly varying distances along a curve through a box.
class Walk {
 public:
  Walk(const Eigen::AlignedBox3d& space, Random* random)
      : center_(space.center()), half_(space.sizes() / 2), curve_(0.05, 0.16, random) {}

  Vector3d Position() const { return At(place_); }

  // Goes on to the next point of the curve at this distance.
  void Advance(double step_m) {
    const Vector3d from = Position();
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
  Vector3d At(double place) const { return center_ + half_.cwiseProduct(curve_.At(place)); }

  Vector3d center_, half_;
  Wander3 curve_;
  double place_ = 0;
};

// x right, y down, z along the gaze, the horizon level.
Eigen::Quaterniond LevelOrientation(const Vector3d& gaze) {
  Eigen::Matrix3d world_from_camera;
  const Vector3d right = gaze.cross(Vector3d::UnitZ()).normalized();
  world_from_camera << right, gaze.cross(right), gaze;
  return Eigen::Quaterniond(world_from_camera);
}

double Angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// A gaze that glides from target to target and never rests: it moves on the sphere of directions
// at a given speed and only steers, turning its heading little by little towards the target.
class Gaze {
 public:
  Gaze(const std::vector<Vector3d>& targets, const Vector3d& position, Random* random)
      : targets_(targets), random_(random) {
    ChooseTarget(position);
    direction_ = (targets_[target_] - position).normalized();
    heading_ = direction_.cross(Vector3d::UnitZ()).normalized();
    ChooseTarget(position);
  }

  Eigen::Quaterniond Orientation() const { return LevelOrientation(direction_); }

  // Moves on so that the camera's orientation turns by this angle.
  void Advance(const Vector3d& position, double turn_rad) {
    constexpr double kReached_rad = 9 * kRadPerDeg;
    constexpr int kMostFrames = 90;
    if (Angle(direction_, targets_[target_] - position) < kReached_rad ||
        ++frames_on_target_ > kMostFrames || !InSight(targets_[target_] - position)) {
      ChooseTarget(position);
    }
    Steer((targets_[target_] - position).normalized());
    const Eigen::Quaterniond before = Orientation();
    const Vector3d direction = direction_, heading = heading_;
    double arc = turn_rad;
    for (int i = 0; i < 4; ++i) {  // the camera turns more than its gaze where it looks up or down
      direction_ = std::cos(arc) * direction + std::sin(arc) * heading;
      heading_ = std::cos(arc) * heading - std::sin(arc) * direction;
      arc *= turn_rad / RotationAngle<double>(before.conjugate() * Orientation());
    }
  }

 private:
  static bool InSight(const Vector3d& to_target) {
    const double elevation = std::asin(to_target.z() / to_target.norm());
    return to_target.norm() > 0.6 && elevation > -52 * kRadPerDeg && elevation < 25 * kRadPerDeg;
  }

  // Another target, at random: one in sight and not far behind if there is any.
  void ChooseTarget(const Vector3d& position) {
    constexpr int kAttempts = 30;
    constexpr double kFar_m = 3.5;
    const int last = target_;
    for (int i = 0; i < kAttempts; ++i) {
      target_ = random_->Index(static_cast<int>(targets_.size()));
      const Vector3d to_target = targets_[target_] - position;
      if (target_ != last && InSight(to_target) && to_target.norm() < kFar_m &&
          Angle(direction_, to_target) < 100 * kRadPerDeg) {
        break;
      }
    }
    frames_on_target_ = 0;
  }

  void Steer(const Vector3d& to_target) {
    constexpr double kMostTurn_rad = 7 * kRadPerDeg;
    const double wanted =
        std::atan2(direction_.cross(heading_).dot(to_target), heading_.dot(to_target));
    const double turn = std::clamp(wanted, -kMostTurn_rad, kMostTurn_rad);
    heading_ = (Eigen::AngleAxisd(turn, direction_) * heading_).normalized();
  }

  const std::vector<Vector3d>& targets_;
  Random* random_;
  int target_ = -1;
  int frames_on_target_ = 0;
  Vector3d direction_ = Vector3d::UnitY(), heading_ = Vector3d::UnitX();
};

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
  Vector3d TrembleAt(int frame) const { return amplitude_ * tremble_.At(frame / fps_); }

 private:
  static constexpr double kShareOfSpeed = 0.7;
  static constexpr double kFastest_hz = 4;

  double middle_, swing_, fps_, amplitude_;
  Wander speed_;
  Wander3 tremble_;
};

double LeastDistance(const Scene& scene, Walk walk, int frames, double step_m) {
  constexpr int kFramesApart = 10;
  double least = scene.Distance(walk.Position());
  for (int i = 0; i < frames; ++i) {
    walk.Advance(step_m);
    if (i % kFramesApart == 0) least = std::min(least, scene.Distance(walk.Position()));
  }
  return least;
}

// Of some random walks the one that keeps best away from objects.
Walk ChooseWalk(const Scene& scene, int frames, double step_m, Random* random) {
  constexpr int kCandidates = 24;
  Walk best(scene.camera_space, random);
  double best_distance = LeastDistance(scene, best, frames, step_m);
  for (int i = 1; i < kCandidates; ++i) {
    const Walk walk(scene.camera_space, random);
    const double distance = LeastDistance(scene, walk, frames, step_m);
    if (distance > best_distance) {
      best = walk;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace

void PathOptions::Validate() const {
  Check(frames_per_second > 0, "frames_per_second", frames_per_second, "must be positive");
  Check(min_step_m > 0, "min_step_m", min_step_m, "must be positive");
  Check(max_step_m >= min_step_m, "max_step_m", max_step_m, "must not be below min_step_m");
  Check(min_turn_deg > 0, "min_turn_deg", min_turn_deg, "must be positive");
  Check(max_turn_deg >= min_turn_deg, "max_turn_deg", max_turn_deg,
        "must not be below min_turn_deg");
}

Trajectory MakePath(const Scene& scene, int frames, std::uint64_t seed,
                    const PathOptions& options) {
  options.Validate();
  if (frames < 1) throw InputError(Concat("frames is ", frames, ", must be at least 1"));
  constexpr std::uint64_t kStream = 1;  // apart from what the scene draws from the same seed
  Random random(seed, kStream);
  const double fps = options.frames_per_second;
  const Hand moving(options.min_step_m, options.max_step_m, fps, &random);
  const Hand turning(options.min_turn_deg * kRadPerDeg, options.max_turn_deg * kRadPerDeg, fps,
                     &random);
  Walk walk = ChooseWalk(scene, frames, options.max_step_m, &random);
  Gaze gaze(scene.targets, walk.Position(), &random);
  Trajectory path;
  path.reserve(frames);
  for (int i = 0; i < frames; ++i) {
    const Eigen::Quaterniond tremble = QuaternionExp<double>(turning.TrembleAt(i));
    path.push_back({i / fps, Rigid3d((gaze.Orientation() * tremble).normalized(),
                                     walk.Position() + moving.TrembleAt(i))});
    walk.Advance(moving.SpeedAt(i));
    gaze.Advance(walk.Position(), turning.SpeedAt(i));
  }
  return path;
}

}  // namespace surfit
