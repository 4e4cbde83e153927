#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "surfit/core/image.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inertial.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/registration/icp.h"
#include "surfit/slam/backend.h"
#include "surfit/tracking/tracking.h"

namespace surfit {

class FramePreprocessor;
class Mapper;
class OptionVisitor;
class Relocalizer;
class Tracker;
struct Prediction;
struct PreprocessedFrame;
struct Tracked;

// SLAM: the pipeline from frames to poses and a map. Does not read or write files. Read
// Slam::Process() in src/slam/slam.cc first.

struct SlamOptions : TrackingOptions {
  PreprocessOptions preprocess;
  FusionOptions fusion;
  RenderOptions render;
  // Fusion period: every map_period-th tracked frame is fused and gets a new model view. 1: all
  // frames. With photometric residuals, each frame gets its own view.
  int map_period = 2;
  LoopOptions loops;
  CalibrationOptions calibration;
  // Frames arrive at the rate of a camera. Tracking does not wait for loop closure or calibration,
  // so the result depends on the machine. Relocalisation finds nothing during a loop task.
  bool real_time = false;
  // Every hold_out-th frame is tracked, but not fused, for the evaluation of the map. Lost frames
  // are counted. The first frame of a map is always fused. 0: off. 1 is invalid.
  int hold_out = 0;

  void Visit(OptionVisitor& visitor);
};

// Wall time of each stage of a frame.
struct StageTimes {
  double preprocess_ms = 0;
  double predict_ms = 0;  // rendering for this frame or the next one
  double track_ms = 0;
  double fuse_ms = 0;
  double correct_ms = 0;  // corrections by loop closures and calibrations
};

// Outcome of a frame. See FrameState for `state`.
struct FrameReport {
  int index = 0;
  double stamp_s = 0;
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;     // undefined if lost
  bool found_by_search = false;  // pose by global registration, relocalisation or confirmation
  bool has_own_view = false;     // the model view was rendered for this frame
  bool is_fused = false;
  bool is_held_out = false;  // excluded from fusion by SlamOptions::hold_out
  // Ratio of points on moving objects. These points are neither registered nor fused.
  double moving_ratio = 0;
  // The tracked features have two motions: the camera may be registered to a moving object. If most
  // features contradict the pose, the frame is lost.
  bool has_two_motions = false;
  Image<std::uint8_t> moving;  // cells with moving objects: not 0; empty without moving objects
  IcpResult icp;               // last registration of a tracked or lost frame
  // Last keyframe before this frame, as frame index; -1: none, or pose by search.
  int keyframe = -1;
  // Pose relative to this keyframe and the covariance (rad, m) of its left perturbation, in the
  // camera frame of the keyframe. It is the sum of the registration covariances of the keyframe,
  // this frame and the fused frames between. Each fused frame moves the map by its error. Priors
  // are not included. Errors of the sensor over more than a tenth of the image width are not
  // included. Empty without a keyframe, and if a direction of one of these frames is
  // unobservable.
  Rigid3d keyframe_from_camera;
  std::optional<Matrix6d> covariance;
  FusionReport fusion;                  // if fused
  std::optional<PosedFrame> confirmed;  // lost frame with a pose that this frame confirms
  StageTimes times;

  bool HasPose() const { return state != FrameState::kLost; }
};

// Dense SLAM by point-based fusion. Frames are registered to a rendered view of the map, and fused
// into the map. Loop closures correct the poses and deform the map. Poses are world_from_camera in
// m; camera axes are x right, y down, z forward.
//
// Not thread-safe. Uses up to ThreadLimit threads, and one background thread each for loop closure
// and calibration.
class Slam {
 public:
  // Starts with an empty map. The pose of the first frame is `world_from_first_camera`. The camera
  // of the sensor must have fy > 0, which is not checked. Throws InputError for an invalid sensor
  // or invalid options.
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera);
  // Continues from the state of another Slam of the same sensor. The camera is relocalised by
  // keyframes. If the first frame follows within 1 s, the camera may also be tracked from the last
  // pose. The second frame must confirm this pose. Frame indices must be larger than those of the
  // state.
  //
  // Enables calibration if the state is calibrated. Throws InputError for an invalid sensor,
  // invalid options, disabled relocalisation, frame-to-frame tracking, or a state without
  // keyframes. Other errors of the state are not checked.
  Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use);
  ~Slam();

  // Tracks and fuses the next frame. Frames must have increasing indices and times (stamp_s), which
  // is not checked. The frame may be lost: see FrameReport::state. Throws if the depth image does
  // not have the size of the sensor, or if the colour image has another number of pixels. Throws
  // the exception of a failed loop closure or calibration.
  FrameReport Process(const RgbdFrame& frame);

  // Fuses the next frame at a given pose, without tracking. Ends calibration, because a calibration
  // would also change given poses. Throws and throws like Process().
  FrameReport ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera);

  // Sets a callback for the report of each frame, called as soon as the pose is known. At this
  // time, the report lacks `is_fused`, `is_held_out`, `fusion`, `confirmed` and `times`. The
  // callback runs on the thread of Process(). It must not throw or call this object.
  void OnPose(std::function<void(const FrameReport&)> call);

  // Sets a callback for each frame whose tracking and global registration have failed, also if it
  // then begins a submap. Not called before the first pose in an empty map, and for frames that
  // only the check of two motions rejects. It runs on the thread of Process(). References in
  // LostFrame are valid during the call. It must not call this object. Process() passes on
  // exceptions of the callback.
  void OnLostFrame(std::function<void(const LostFrame&)> call);

  // Uses the trajectory of another source, for example of a phone or a robot. Its poses are
  // world_from_body, in any world frame, at the times of the frames. The offset between body and
  // camera is constant and unknown. The prior predicts each pose, is a motion prior, and adds edges
  // to the pose graph. Stretches that contradict the registration are rejected. Throws InputError
  // for fewer than two poses, and if a frame has a pose.
  void UsePriorPoses(Trajectory world_from_body);
  // std::nullopt without prior poses.
  std::optional<PriorPoseSummary> prior_poses() const;

  // Predicts camera poses by an inertial sensor, whose clock is that of the frames up to the time
  // offset of its calibration. The report is empty without a sensor. Throws if a frame has been
  // processed.
  void UseImu(ImuRecording recording);
  ImuReport imu_report() const;

  // Lost frame whose pose follows from the inertial sensor, relative to an earlier frame.
  struct BridgedFrame {
    int index = 0;
    double stamp_s = 0;
    int before = 0;  // index of the last frame with a pose before it
    Rigid3d before_from_camera;
  };
  // Lost frames of stretches of up to 1.1 s between frames of one trajectory segment. Call after
  // Finish().
  const std::vector<BridgedFrame>& bridged_frames() const { return bridged_; }

  // Replaces FindLoops() for loop closure. Throws without LoopOptions::HasViews(), and if a frame
  // has a pose, also in a continued state.
  void UseLoopFinder(LoopFinder finder);

  // Sets a callback for each new keyframe, called by the thread of Process(). It must not throw or
  // call this object. Throws InputError without LoopOptions::HasViews().
  void OnKeyframe(KeyframeCall call);

  // Replaces SlamOptions::map_period for the following frames. Use a longer period if frames arrive
  // too fast. Frames are then registered with half of IcpOptions::min_source_rows, fewer frames are
  // weakly constrained, and TrackingOptions::max_view_shift is 1.5 times as large. Frames after
  // lost or weakly constrained frames are not fused out of turn, and no view is drawn ahead of the
  // next frame. Throws InputError unless `frames` is at least 1.
  void SetMapPeriod(int frames);

  // Completes loop closure and calibration, and applies their corrections. Call after the last
  // frame. Does nothing in localisation. Throws the exception of a failed task.
  void Finish();

  // Map in the world frame. It changes with each frame. The reference is valid until this object is
  // destroyed.
  const SurfelMap& map() const;
  // Number of duplicate surfels that corrections have merged.
  std::size_t merged_duplicates() const;
  // Number of map corrections by loop closures and calibrations.
  int corrections_of_map() const;
  // Input sensor with the estimated calibration.
  DepthSensor sensor() const;
  // Null without loops and calibration. Valid until UseLoopFinder(), or until this object is
  // destroyed.
  const Backend* backend() const;

 private:
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera, StateUse use);

  void MakeBackend(LoopFinder finder);
  void UsePriorEdges();
  void NoteLost(const RgbdFrame& frame);
  void SmoothByImu();
  void Correct(const RgbdFrame& frame, StageTimes* times);
  void Apply(const WorldCorrection& correction, int frame_index);
  PreprocessedFrame Preprocess(const RgbdFrame& frame, const CameraMotion& motion,
                               StageTimes* times);
  Prediction Predict(const PreprocessedFrame& frame, StageTimes* times);
  void PredictAhead(const RgbdFrame& frame, StageTimes* times);
  Tracked Track(const PreprocessedFrame& frame, const Prediction& prediction, StageTimes* times);
  FrameReport ReportDuplicate(const RgbdFrame& frame, const StageTimes& times);
  FrameReport Integrate(PreprocessedFrame frame, Tracked tracked, StageTimes* times);
  std::optional<PosedFrame> AddConfirmed(const Tracked& tracked);
  void Fuse(const PreprocessedFrame& frame, const Tracked& tracked, FrameReport* report,
            StageTimes* times);
  bool IsHeldOut(const Tracked& tracked) const;
  void SetCovariance(const Tracked& tracked, FrameReport* report) const;
  void UpdateCovarianceOfMap(const Tracked& tracked, bool is_keyframe, const FrameReport& report);
  // Back end that stores frames. Null without loops and calibration, and in localisation.
  Backend* keeper() const { return use_ == StateUse::kLocalize ? nullptr : backend_.get(); }

  const DepthSensor sensor_;  // input sensor
  const SlamOptions options_;
  const StateUse use_;
  std::unique_ptr<FramePreprocessor> preprocessor_;
  std::unique_ptr<Mapper> mapper_;
  // Frames without a pose: index and capture time. Empty without an inertial sensor.
  std::vector<std::pair<int, double>> lost_;
  std::vector<BridgedFrame> bridged_;
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<Backend> backend_;          // null without loops and calibration
  std::unique_ptr<Relocalizer> relocalizer_;  // null without loops
  int frame_count_ = 0;
  std::function<void(const FrameReport&)> on_pose_;
  // Sum of Tracked::registered_covariance of the last keyframe and the fused frames since, in the
  // camera frame of the keyframe. The first frame of a map has none.
  std::optional<Matrix6d> covariance_of_map_;
  KeyframeCall on_keyframe_;  // stored for a back end that replaces the present one
};

}  // namespace surfit
