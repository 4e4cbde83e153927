#pragma once

#include <optional>

#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/tracking/tracking.h"
#include "tracking/motion_prior.h"
#include "tracking/tracking_state.h"

namespace surfit {

struct MeasuredMotion {
  Rigid3d last_from_frame;
  double seconds = 0;
  bool is_found = false;               // pose from PoseSearch
  bool is_expected = false;            // the pose is near the predicted pose
  std::optional<Matrix6d> covariance;  // in the camera frame
};

class MotionModel {
 public:
  // Keeps a reference to the options.
  explicit MotionModel(const TrackingOptions& options);

  // Pose of the next frame. std::nullopt for the model so3, which needs the images of the
  // frame.
  std::optional<Rigid3d> PredictPose(const TrackingState& state,
                                     const Rigid3d& world_from_last) const;
  // Zero after lost frames.
  CameraMotion PredictMotion(const TrackingState& state) const;
  // Covariance (rad, m) of the motion to the next frame. std::nullopt without a motion prior.
  std::optional<Matrix6d> PriorCovariance(const TrackingState& state, double seconds) const;
  // Returns whether there is a motion prior, and few enough frames were lost to predict the
  // motion.
  bool HasPredictableMotion(const TrackingState& state) const;

  // Zero after lost frames and for intervals of 0.1 s or more.
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
  Rigid3d last_from_next_;  // predicted motion of constant_velocity
};

}  // namespace surfit
