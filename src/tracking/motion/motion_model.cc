#include "tracking/motion/motion_model.h"

namespace surfit {
namespace {

// Longest interval with approximately constant velocity of a hand-held camera.
constexpr double kMaxMotion_s = 0.1;

// Standard deviation of accelerations without the option. A hand moves a camera with 1 to 4 m/s^2.
constexpr double kAcceleration_m_per_s2 = 3;

}  // namespace

MotionModel::MotionModel(const TrackingOptions& options)
    : options_(options),
      prior_(options.acceleration_m_per_s2 > 0 ? options.acceleration_m_per_s2
                                               : kAcceleration_m_per_s2,
             options.angular_acceleration_rad_per_s2) {}

std::optional<Rigid3d> MotionModel::PredictPose(const TrackingState& state,
                                                const Rigid3d& world_from_last) const {
  if (!state.is_localised) return world_from_last;
  if (options_.motion_model == "so3") return std::nullopt;
  if (options_.motion_model == "constant_pose") return world_from_last;
  if (state.lost_frames > 0 && !HasPredictableMotion(state)) return world_from_last;
  Rigid3d expected = world_from_last;
  for (int i = 0; i <= state.lost_frames; ++i) expected = expected * last_from_next_;
  return expected;
}

CameraMotion MotionModel::PredictMotion(const TrackingState& state) const {
  return state.lost_frames > 0 ? CameraMotion() : motion_;
}

std::optional<Matrix6d> MotionModel::PriorCovariance(const TrackingState& state,
                                                     double seconds) const {
  const bool is_predictable =
      options_.motion_model == "constant_velocity" && state.HasPredictableMotion();
  if (!is_predictable || !(seconds > 0)) return std::nullopt;
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
  if (is_next && motion.covariance) prior_.Keep(*motion.covariance, motion.seconds);
}

void MotionModel::Lose(const TrackingState& state) {
  if (!HasPredictableMotion(state)) prior_.Forget();
}

}  // namespace surfit
