#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "surfit/core/image.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
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

// SLAM: the pipeline from frames to poses and a map, and its state. Depends on tracking, mapping,
// loop closure and calibration. Does not read or write files. Read Slam::Process() in
// src/slam/slam.cc first.

// Options of SLAM.
struct SlamOptions : TrackingOptions {
  PreprocessOptions preprocess;
  FusionOptions fusion;
  RenderOptions render;
  // Every map_period-th tracked frame is fused and gets a new model view. 1: all frames. At 30 Hz,
  // the views of consecutive frames are almost equal. With photometric residuals, each frame gets
  // its own view.
  int map_period = 2;
  LoopOptions loops;
  CalibrationOptions calibration;
  // Frames arrive at the rate of a camera. Tracking does not wait for loop closure or calibration,
  // so the result depends on the machine. Only relocalisation waits for the current loop closure
  // task.
  bool real_time = false;
  // Every hold_out-th frame is tracked, but not fused, for the evaluation of the map. The first
  // frame of a map is always fused. 0: all frames can be fused. 1 is invalid.
  int hold_out = 0;

  void Visit(OptionVisitor& visitor);
};

// Wall time of each stage.
struct StageTimes {
  double preprocess_ms = 0;
  double predict_ms = 0;  // rendering, for this frame or in advance for the next frame
  double track_ms = 0;
  double fuse_ms = 0;
  double correct_ms = 0;  // corrections by loop closures and calibrations
};

// Outcome of a frame.
struct FrameReport {
  int index = 0;
  double stamp_s = 0;
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // undefined if lost
  bool found_by_search =
      false;  // found by search: global registration, relocalisation or confirmation
  bool has_own_view = false;  // the reference view was rendered for this frame
  bool is_fused = false;      // fused into the map
  bool is_held_out = false;   // tracked, and excluded from fusion by SlamOptions::hold_out
  // Ratio of the points on moving objects, which are neither registered nor fused.
  double moving_ratio = 0;
  // The feature check found two motions: the camera may be registered to a moving object. If most
  // features contradict the pose, the frame is lost.
  bool has_two_motions = false;
  Image<std::uint8_t> moving;  // cells with moving objects: not 0; empty without moving objects
  IcpResult icp;               // last registration of a tracked or lost frame
  FusionReport fusion;         // if fused
  std::optional<PosedFrame> confirmed;  // previous lost frame, if this frame has confirmed its pose
  StageTimes times;

  bool HasPose() const { return state != FrameState::kLost; }
};

// Dense SLAM by point-based fusion: each frame is registered to a model view, and every
// SlamOptions::map_period-th frame is fused into the map at its pose. With loop closure, the map is
// deformed with the corrected poses.
//
// Not thread-safe. Uses up to ThreadLimit threads, and one background thread each for loop closure
// and calibration.
class Slam {
 public:
  // The camera of the sensor has fy > 0. Throws InputError for an invalid sensor or invalid
  // options.
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera);
  // Continues from the state of another Slam of the same sensor. Loop closure must be enabled, and
  // tracking must be frame_to_model. The camera pose is unknown: the camera is relocalised by
  // keyframes, or tracked from the last pose if the first frame follows within 1 s. The next frame
  // must confirm the first pose. Frame indices must be larger than those of the state. Throws
  // InputError for options that do not meet these conditions, and for a state without keyframes.
  Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use);
  ~Slam();

  // Tracks and fuses the next frame. Frames must have increasing indices and timestamps. Aborts if
  // an image does not have the size of the sensor. Throws the exception of a failed loop closure or
  // calibration.
  FrameReport Process(const RgbdFrame& frame);

  // Fuses the next frame at a given pose. Ends calibration, because given poses are not corrected
  // by it. Aborts as Process().
  FrameReport ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera);

  // Sets a callback for the report of each frame as soon as its outcome is known. The report has no
  // fusion, `confirmed` and times yet. The callback runs on the thread of Process(). It must not
  // throw or call this object.
  void OnPose(std::function<void(const FrameReport&)> call);

  // Sets a callback for each frame whose registration and search have failed.
  void OnLostFrame(std::function<void(const LostFrame&)> call);

  // Replaces FindLoops(). Aborts unless loops are enabled and no frame was processed.
  void UseLoopFinder(LoopFinder finder);

  // Sets a callback for each new keyframe. Throws InputError unless loops are enabled.
  void OnKeyframe(KeyframeCall call);

  // Sets the period of fusion for the following frames, instead of SlamOptions::map_period: a
  // longer period fuses fewer frames if they arrive too fast. Frames after lost or weakly
  // constrained frames are then no longer fused out of turn. Throws InputError unless `frames` is
  // at least 1.
  void SetMapPeriod(int frames);

  // Completes loop closure and calibration, and applies their corrections. Call after the last
  // frame.
  void Finish();

  // The map changes with each frame. The reference is valid until this object is destroyed.
  const SurfelMap& map() const;
  // Number of duplicate surfels that corrections have merged.
  std::size_t merged_duplicates() const;
  // Number of map changes other than fusion: corrections by loop closures and calibrations.
  int corrections_of_map() const;
  // Sensor with the estimated calibration.
  DepthSensor sensor() const;
  // Null without loops and calibration.
  const Backend* backend() const;

 private:
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera, StateUse use);

  void MakeBackend(LoopFinder finder);
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
  // Back end that stores the frames: null without loops and calibration, and for localisation.
  Backend* keeper() const { return use_ == StateUse::kLocalize ? nullptr : backend_.get(); }

  const DepthSensor sensor_;  // input sensor
  const SlamOptions options_;
  const StateUse use_;
  std::unique_ptr<FramePreprocessor> preprocessor_;
  std::unique_ptr<Mapper> mapper_;
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<Backend> backend_;          // null without loops and calibration
  std::unique_ptr<Relocalizer> relocalizer_;  // null without loops
  int frame_count_ = 0;
  std::function<void(const FrameReport&)> on_pose_;
  KeyframeCall on_keyframe_;  // stored for a back end that replaces the present one
};

}  // namespace surfit
