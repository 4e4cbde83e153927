#pragma once

#include <optional>

#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/tracking/tracking.h"
#include "tracking/motion/motion_prior.h"
#include "tracking/tracking_state.h"

namespace surfit {

// Motion from the last frame with a pose to the current frame.
struct MeasuredMotion {
  Rigid3d last_from_frame;   // camera frame of the current frame to that of the last frame, m
  double seconds = 0;        // since the last frame with a pose
  bool is_found = false;     // pose from PoseSearch
  bool is_expected = false;  // the pose is near the predicted pose
  std::optional<Matrix6d> covariance;  // rad, m; in the camera frame; std::nullopt: unknown
};

// Predicts the camera motion at constant velocity, and its uncertainty. Call Update() or Lose()
// once per frame, except duplicates. Not thread-safe.
class MotionModel {
 public:
  // Keeps a reference to the options.
  explicit MotionModel(const TrackingOptions& options);

  // Pose of the next frame (camera to world), at constant velocity. `seconds`: time since the last
  // frame with a pose; 0: unknown, so that frames are equally far apart. The motion continues for
  // at most three intervals. Returns `world_from_last`, the pose of the last frame with a pose, if
  // the motion is not predictable, and in a given map without a pose.
  Rigid3d PredictPose(const TrackingState& state, const Rigid3d& world_from_last,
                      double seconds) const;
  // Returns whether the motion from the last frame is a step that no hand makes. The bounds on the
  // change of the motion are 40 m/s^2 and 200 rad/s^2, plus 2 cm and 0.05 rad for errors of the
  // poses. Returns false if no last motion is known.
  bool IsImpossible(const TrackingState& state, const Rigid3d& last_from_frame,
                    double seconds) const;
  // Camera velocity of the last frame with a pose. Zero after lost frames.
  CameraMotion PredictMotion(const TrackingState& state) const;
  // Covariance (rad, m) of the motion to the next frame, in the camera frame. `seconds`: time since
  // the last frame with a pose. std::nullopt if the motion is not predictable, or if `seconds` is
  // not positive.
  std::optional<Matrix6d> PriorCovariance(const TrackingState& state, double seconds) const;
  // Returns whether lost frames continue the motion: acceleration_m_per_s2 > 0, and few enough
  // frames were lost.
  bool HasPredictableMotion(const TrackingState& state) const;

  // Velocity of the motion `last_from_frame` in `seconds`. Zero after lost frames and for intervals
  // of 0.1 s or more.
  static CameraMotion Velocity(const TrackingState& state, const Rigid3d& last_from_frame,
                               double seconds);

  // Adds the motion to a frame with a pose. `state` is the state before this frame.
  void Update(const TrackingState& state, const MeasuredMotion& motion);
  // Adds a lost frame. `state` includes this frame.
  void Lose(const TrackingState& state);

 private:
  const TrackingOptions& options_;
  CameraMotion motion_;
  MotionPrior prior_;
  Rigid3d last_from_next_;  // predicted motion
  double interval_s_ = 0;   // time of this motion; 0: unknown
};

}  // namespace surfit
