#include "tracking/motion/motion_model.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

// Longest interval with approximately constant velocity of a hand-held camera.
constexpr double kMaxMotion_s = 0.1;

// Standard deviation of accelerations without the option. A hand moves a camera with 1 to 4 m/s^2.
constexpr double kAcceleration_m_per_s2 = 3;

// Longest prediction, in intervals between frames.
constexpr double kMaxIntervals = 3;
// Timestamps scatter by less than this ratio of an interval.
constexpr double kJitter = 0.25;

// Bounds of a motion by hand, and on errors of two poses.
constexpr double kMaxAcceleration_m_per_s2 = 40, kMaxAngularAcceleration_rad_per_s2 = 200;
constexpr double kPoseError_m = 0.02, kPoseError_rad = 0.05;

// Time in units of intervals. Scatter of the timestamps is removed.
double IntervalsIn(double seconds, double interval_s) {
  const double ratio = std::min(kMaxIntervals, seconds / interval_s);
  const double rounded = std::round(ratio);
  return std::abs(ratio - rounded) < kJitter ? rounded : ratio;
}

// Repeats the motion `ratio` times, at constant velocity in the camera frame.
Rigid3d Scaled(const Rigid3d& motion, double ratio) {
  const int whole = static_cast<int>(ratio);
  const double rest = ratio - whole;
  Rigid3d scaled;
  for (int i = 0; i < whole; ++i) scaled = scaled * motion;
  if (rest == 0) return scaled;
  const CameraMotion velocity = MotionOver(motion, 1);
  const Eigen::Vector3d turn = rest * velocity.angular_velocity_rad_per_s;
  return scaled * Rigid3d(QuaternionExp<double>(turn),
                          QuaternionExp<double>(0.5 * turn) * (rest * velocity.velocity_m_per_s));
}

}  // namespace

MotionModel::MotionModel(const TrackingOptions& options)
    : options_(options),
      prior_(options.acceleration_m_per_s2 > 0 ? options.acceleration_m_per_s2
                                               : kAcceleration_m_per_s2,
             options.angular_acceleration_rad_per_s2) {}

Rigid3d MotionModel::PredictPose(const TrackingState& state, const Rigid3d& world_from_last,
                                 double seconds) const {
  if (!state.is_localised) return world_from_last;
  if (state.lost_frames > 0 && !HasPredictableMotion(state)) return world_from_last;
  const bool is_timed = seconds > 0 && interval_s_ > 0;
  const double ratio = is_timed ? IntervalsIn(seconds, interval_s_) : state.lost_frames + 1;
  return world_from_last * Scaled(last_from_next_, ratio);
}

bool MotionModel::IsImpossible(const TrackingState& state, const Rigid3d& last_from_frame,
                               double seconds) const {
  if (!state.HasLastPose() || !(seconds > 0) || !(interval_s_ > 0)) return false;
  const Rigid3d expected = Scaled(last_from_next_, IntervalsIn(seconds, interval_s_));
  const Rigid3d step = expected.Inverse() * last_from_frame;
  // Mean velocities change over half of both intervals.
  const double squared_s = seconds * (seconds + interval_s_) / 2;
  return step.translation.norm() > kPoseError_m + kMaxAcceleration_m_per_s2 * squared_s ||
         RotationAngle(step.rotation) >
             kPoseError_rad + kMaxAngularAcceleration_rad_per_s2 * squared_s;
}

CameraMotion MotionModel::PredictMotion(const TrackingState& state) const {
  return state.lost_frames > 0 ? CameraMotion() : motion_;
}

std::optional<Matrix6d> MotionModel::PriorCovariance(const TrackingState& state,
                                                     double seconds) const {
  if (!state.HasPredictableMotion() || !(seconds > 0)) return std::nullopt;
  return prior_.Covariance(seconds);
}

bool MotionModel::HasPredictableMotion(const TrackingState& state) const {
  return options_.acceleration_m_per_s2 > 0 && state.HasPredictableMotion();
}

CameraMotion MotionModel::Velocity(const TrackingState& state, const Rigid3d& last_from_frame,
                                   double seconds) {
  if (!state.HasLastPose() || seconds >= kMaxMotion_s) return {};
  return MotionOver(last_from_frame, seconds);
}

// A motion across lost frames or to a search result does not predict the next motion. The
// prediction is kept if the pose is near the predicted pose.
void MotionModel::Update(const TrackingState& state, const MeasuredMotion& motion) {
  const bool is_next = state.HasLastPose() && !motion.is_found;
  const std::optional<Matrix6d> prior = PriorCovariance(state, motion.seconds);
  motion_ =
      motion.is_found ? CameraMotion() : Velocity(state, motion.last_from_frame, motion.seconds);
  prior_.Forget();
  if (!is_next && prior && motion.is_expected && options_.acceleration_m_per_s2 > 0) {
    prior_.Keep(*prior, motion.seconds);
    return;
  }
  last_from_next_ = is_next ? motion.last_from_frame : Rigid3d();
  interval_s_ = is_next ? motion.seconds : 0;
  if (is_next && motion.covariance) prior_.Keep(*motion.covariance, motion.seconds);
}

void MotionModel::Lose(const TrackingState& state) {
  if (!HasPredictableMotion(state)) prior_.Forget();
}

}  // namespace surfit
