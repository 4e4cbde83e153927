#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/tracking/tracking.h"
#include "tracking/color_trust.h"
#include "tracking/feature_watch.h"
#include "tracking/frame_preprocessor.h"
#include "tracking/frame_registration.h"
#include "tracking/inertial/imu_tracking.h"
#include "tracking/model_views.h"
#include "tracking/motion/motion_model.h"
#include "tracking/motion/prior_poses.h"
#include "tracking/moving_corners.h"
#include "tracking/moving_regions.h"
#include "tracking/pose_search.h"
#include "tracking/tracked.h"
#include "tracking/tracking_state.h"

namespace surfit {

// Predicted pose of a frame, and the view for its registration. `reference` is valid until the next
// Predict(), Update() or PredictAhead().
struct Prediction {
  Rigid3d world_from_camera;
  const ReferenceView* reference = nullptr;
  bool has_own_view = false;  // the view was rendered for this pose
};

// Each frame passes Predict(), Track() and Update() in this order:
//   Predict  motion model, reference view       motion_model.h, model_views.h
//   Track    registration, its validation       frame_registration.h, pose_validation.h
//            search for uncertain frames        pose_search.h
//            feature check of the pose          feature_watch.h
//   Update   state transition                   tracking_state.h
// First, IsDuplicate() is called for each frame. A duplicate gets Repeat() and nothing else. Until
// a frame has a pose, TrackFirst() replaces Predict() and Track(). TrackGiven() replaces them for a
// frame with a given pose. Move() is called between frames. Not thread-safe.
class Tracker {
 public:
  // Keeps a reference to the options and the pointer. `world_from_first_camera`: pose of the first
  // frame; with StartInGivenMap(), the last pose in the map.
  Tracker(const TrackingOptions& options, const Rigid3d& world_from_first_camera,
          ModelViews* views);

  // Keeps the pointer. Null: no place recognition.
  void UseRelocalizer(Relocalizer* relocalizer);
  // Called within Track() if a frame has no pose, also before it begins a new submap. Not called
  // for a frame that TrackFirst() or the feature check loses.
  void OnLostFrame(std::function<void(const LostFrame&)> call) { on_lost_ = std::move(call); }
  // Uses prior poses for the predicted pose, as a motion prior, and in prior_poses(). Call before
  // the first frame.
  void UsePriorPoses(Trajectory world_from_body);
  // Null without prior poses. Valid until the next call.
  const PriorPoses* prior_poses() const { return prior_poses_ ? &*prior_poses_ : nullptr; }
  // Starts with a given map and an unknown camera pose. `last_stamp_s`: time of the last pose in
  // the map. Call before the first frame.
  void StartInGivenMap(double last_stamp_s);

  // Predicts poses by an inertial sensor, with times on the clock of the frames. Call before the
  // first frame.
  void UseImu(ImuRecording recording);
  // Empty without a sensor.
  ImuReport imu_report() const { return imu_ ? imu_->report() : ImuReport(); }
  ImuTracking* imu() const { return imu_.get(); }  // null: no inertial sensor

  // `is_hurried`: registers the following frames with half of IcpOptions::min_source_rows, and
  // treats fewer of them as weakly constrained.
  void Hurry(bool is_hurried) { registration_.Hurry(is_hurried); }

  // Submap of the last pose. Call before the first frame.
  void UseSubmap(int submap) { submap_ = submap; }

  const TrackingState& state() const { return state_; }
  // Returns whether the next frame may need photometric residuals.
  bool NeedsIntensities() const;
  // Predicted velocity during the frame at `stamp_s`. The angular velocity is that of the gyroscope
  // if it is in use. Otherwise, zero after lost frames.
  CameraMotion ExpectedMotion(double stamp_s) const;
  // Camera velocity from the last frame to a pose. Zero after lost frames and for intervals of
  // 0.1 s or more.
  CameraMotion MotionTo(double stamp_s, const Rigid3d& world_from_camera) const;
  // As above. Also zero if the pose was found by search.
  CameraMotion MotionTo(double stamp_s, const Tracked& tracked) const;

  // Returns whether the depth equals the depth of the previous frame. Call once per frame. False
  // before the first frame with a pose.
  bool IsDuplicate(const RgbdFrame& frame);
  // Returns whether the colour of the frame may be used, see ColorTrust. Call once per frame with
  // colour, before IsDuplicate(). If it is false, give the frame without colour.
  bool AcceptsColor(const RgbdFrame& frame);
  // Outcome of a duplicate frame: the last pose, or lost after a lost frame. Update() must not
  // follow.
  Tracked Repeat() const;
  // The first frame is lost if it has too little depth.
  Tracked TrackFirst(const PreprocessedFrame& frame);
  // Outcome of a frame with a given pose, without any check.
  Tracked TrackGiven(const PreprocessedFrame& frame, const Rigid3d& world_from_camera);

  // Requires a previous frame with a pose, or a given map.
  Prediction Predict(const PreprocessedFrame& frame);
  // The tentative pose of the last frame is confirmed or dropped here.
  Tracked Track(const PreprocessedFrame& frame, const Prediction& prediction);
  // Completes a frame. Not for duplicates. `frame`: without the pixels of moving objects. Also for
  // lost frames.
  void Update(PreprocessedFrame frame, Tracked tracked);
  // Renders the model view of the next frame in advance. Optional, after Update(). It saves time in
  // Predict(). `has_color`: the next frame will have colour.
  void PredictAhead(bool has_color);

  // Applies a correction of the world frame to all stored poses. `new_from_old_now` moves the last
  // pose. A tentative pose in another submap moves with its keyframe, by the correction
  // `new_from_old_at` of the frame of the keyframe.
  void Move(const Rigid3d& new_from_old_now,
            const std::function<Rigid3d(int frame)>& new_from_old_at);

 private:
  void WatchCorners(const PreprocessedFrame& frame);
  bool LacksIntensities(const PreprocessedFrame& frame, const Tracked& tracked) const;
  CellMask MovingCells(const PreprocessedFrame& frame, const Tracked& tracked);
  Tracked TrackFrom(const PreprocessedFrame& frame, const Prediction& prediction, Tracked tracked);
  Tracked CheckFeatures(const PreprocessedFrame& frame, Tracked tracked);
  void WarnOfColor(int frame);
  Tracked ByDepthAlone(const PreprocessedFrame& frame, const Prediction& prediction,
                       Tracked tracked);
  Tracked RegisterOrSearch(const PreprocessedFrame& frame, const Prediction& prediction,
                           Tracked registered);
  Tracked Verified(const PreprocessedFrame& frame, const Prediction& prediction,
                   Tracked tracked) const;
  Tracked Search(const PreprocessedFrame& frame, Tracked tracked) const;
  bool IsImpossible(const PreprocessedFrame& frame, const Tracked& tracked) const;
  // Options of the first registration of the next frame.
  IcpOptions IcpOptionsInUse() const;
  Tracked Register(const PreprocessedFrame& frame, const ReferenceView& reference,
                   const Rigid3d& world_from_predicted) const;
  Tracked AgainstNewest(const PreprocessedFrame& frame, Tracked tracked) const;
  std::optional<Tracked> CompareWithTentative(const PreprocessedFrame& frame, Tracked* tracked);
  std::optional<Tracked> Confirmed(const PreprocessedFrame& frame, const Tracked& tracked,
                                   const TentativePose& tentative) const;
  bool IsUncertain(const PreprocessedFrame& frame, const Prediction& prediction,
                   const Tracked& tracked) const;
  bool IsFar(const PreprocessedFrame& frame, const Rigid3d& world_from_camera) const;
  Rigid3d WithMeasuredMotion(const PreprocessedFrame& frame, const Tracked& tracked) const;
  std::optional<Tracked> InNewSubmap(const PreprocessedFrame& frame, const Tracked& tracked);

  Prediction PredictAt(const PreprocessedFrame& frame);
  bool AgreesWithPrior(const PreprocessedFrame& frame, const Tracked& tracked,
                       const Prediction& prediction) const;
  void ComparePrior(const PreprocessedFrame& frame, const Tracked& tracked);
  // Mean age of the visible surfels, s. 0: unknown.
  double ModelAge(const RgbdFrame& frame);
  // Poses are predicted by the inertial sensor if it is in use.
  std::optional<ImuTracking::Prediction> PredictByImu(double stamp_s) const;
  std::optional<MotionUncertainty> PredictedUncertainty(const PreprocessedFrame& frame) const;
  Tracked WithoutImu(const PreprocessedFrame& frame, const Prediction& prediction, Tracked tracked);
  bool AgreesWithImu(const Tracked& tracked) const;
  bool IsHeldByPrior(const Tracked& tracked) const;
  void AddToImu(const PreprocessedFrame& frame, const Tracked& tracked);
  Rigid3d PredictedPose(double seconds) const;
  std::optional<Rigid3d> ExpectedPose(const PreprocessedFrame& frame) const;
  bool UpdateView(const Rigid3d& world_from_predicted, bool has_intensities);
  double SecondsTo(const PreprocessedFrame& frame) const {
    return frame.images.stamp_s - last_stamp_s_;
  }

  const TrackingOptions& options_;
  ModelViews* views_;
  MovingRegions regions_;
  FrameRegistration registration_;
  PoseSearch search_;
  Relocalizer* relocalizer_ = nullptr;  // null: no place recognition
  FeatureWatch features_;
  MovingCorners corners_;
  ColorTrust color_trust_;
  bool warned_of_color_ = false;
  std::function<void(const LostFrame&)> on_lost_;

  TrackingState state_;
  std::optional<TentativePose> tentative_;  // in TrackingPhase::kTentative
  ReferenceView last_;  // last frame with a pose; `view` only if the options need it
  double last_stamp_s_ = 0;
  int submap_ = 0;           // of the last pose
  int lost_with_depth_ = 0;  // lost frames with enough depth since the last pose
  MotionModel motion_model_;
  std::unique_ptr<ImuTracking> imu_;                       // null: no inertial sensor
  std::optional<ImuTracking::Prediction> imu_prediction_;  // for the frame of Predict()
  std::optional<PriorPoses> prior_poses_;
  std::optional<PriorMotion> prior_motion_;      // to the present frame; std::nullopt: not used
  Rigid3d world_from_registered_;                // last pose by registration alone
  Matrix6d last_covariance_ = Matrix6d::Zero();  // of the last pose; only with prior poses
  struct FrameTime {
    int index;
    double stamp_s;
  };
  std::optional<FrameTime> first_frame_;  // that was compared with the prior
  Image<float> last_depth_m_;
};

}  // namespace surfit
