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

class FramePreparation;
class Mapper;
class OptionVisitor;
class Relocalizer;
class Tracker;
struct Prediction;
struct PreparedFrame;
struct Tracked;

// SLAM: the pipeline from frames to poses and a map, and its state. Depends on tracking, mapping,
// loop closure and calibration. Reads and writes no files. Read Slam::Process() in src/slam/slam.cc
// first.

// Options of SLAM.
struct SlamOptions : TrackingOptions {
  PreprocessOptions preprocess;
  FusionOptions fusion;
  RenderOptions render;
  // Every map_period-th tracked frame is fused, and gets a new model view. 1: all frames. At 30 Hz
  // the views of consecutive frames are almost equal. With photometric residuals, each frame gets
  // its own view.
  int map_period = 2;
  LoopOptions loops;
  CalibrationOptions calibration;
  // Frames come at a camera's rate: none waits for what is found of loops and the camera, which
  // takes effect when it is there. So the result depends on the machine. Else a frame that it does
  // not depend on waits.
  bool real_time = false;
  // The last of so many frames is tracked, but never fused: the map can be judged by it. A frame
  // that begins a map is fused. 0: all frames are.
  int hold_out = 0;

  void Visit(OptionVisitor& visitor);
};

// Wall time spent in each stage, milliseconds.
struct StageTimes {
  double prepare_ms = 0;
  double predict_ms = 0;  // drawing the map, for this frame or ahead for the next
  double track_ms = 0;
  double fuse_ms = 0;
  double correct_ms = 0;  // of the map, by loops
};

// What became of one frame.
struct FrameReport {
  int index = 0;
  double stamp_s = 0;
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // meaningless if lost
  bool found_again = false;   // tracked after a jump, by SlamOptions::initialize
  bool has_own_view = false;  // the map was drawn for it, unless it is not to be tracked against
  bool is_fused = false;      // into the map
  bool is_held_out = false;   // tracked, but not to be fused: SlamOptions::hold_out
  double moving_share = 0;    // of its points, those that move by themselves: neither tracked nor
                              // fused
  // The images were asked, and parts of them have moved apart: the camera may be seen against
  // something that moves. Where most of them speak against the pose, it is lost.
  bool is_apart = false;
  Image<std::uint8_t>
      moving;           // where they are: cells of the image, not 0; empty where nothing moves
  IcpResult icp;        // of a tracked or lost frame
  FusionReport fusion;  // of a fused frame
  std::optional<PosedFrame> confirmed;  // the lost frame before, whose pose this frame confirms
  StageTimes times;

  bool HasPose() const { return state != FrameState::kLost; }
};

// Dense SLAM by point-based fusion: each frame is registered to what the map predicts, and one of
// SlamOptions::map_period is fused into the map at the pose found. Where SlamOptions::loops are
// enabled, the map follows the poses that closed loops correct.
class Slam {
 public:
  // The sensor's camera has fy > 0. Throws InputError for a bad sensor or bad options.
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera);
  // Takes up what another Slam has known of the same sensor, with loops enabled and tracking from
  // frame to model. The camera may be anywhere: it is looked for among the keyframes, and from the
  // last pose if the first frame follows that soon; what is found counts once the next frame
  // agrees. Frames' indices must go on from the state's. Throws InputError for options that do not
  // fit.
  Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use);
  ~Slam();

  // Tracks and fuses the next frame. The frame's size must be the sensor's.
  FrameReport Process(const RgbdFrame& frame);

  // Fuses the next frame at a known pose. From then on the camera stays as it was found: it is not
  // calibrated by poses that must not move.
  FrameReport ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera);

  // Sets a callback for the report of each tracked or lost frame before its fusion, which takes
  // longer than tracking. The callback must not throw, nor call this object.
  void OnPose(std::function<void(const FrameReport&)> call);

  // To be called with each frame that tracking loses.
  void OnLostFrame(std::function<void(const LostFrame&)> call);

  // How loops are found, instead of FindLoops(). To be called before the first frame, with loops
  // enabled.
  void UseLoopFinder(LoopFinder finder);

  // To be called with each new keyframe, with loops enabled.
  void OnKeyframe(KeyframeCall call);

  // From the next frame on, in place of SlamOptions::map_period: where frames come faster than they
  // are done, fewer of them are fused. If it is longer than that one, min_turn_eigenvalue no longer
  // makes frames be fused out of turn. Throws InputError unless that is at least 1.
  void SetMapPeriod(int frames);

  // Takes in what is still being found out about loops and the camera. To be called after the last
  // frame.
  void Finish();

  const SurfelMap& map() const;
  // Surfels that became part of others when the map was moved, in all.
  std::size_t merged_doubles() const;
  // How often surfels have changed that no frame was fused to.
  int corrections_of_map() const;
  // Sensor with the estimated calibration.
  DepthSensor sensor() const;
  // Null unless loops or calibration are enabled.
  const Backend* backend() const;

 private:
  Slam(const DepthSensor& sensor, const SlamOptions& options,
       const Rigid3d& world_from_first_camera, StateUse use);

  void MakeBackend(LoopFinder finder);
  void Correct(const RgbdFrame& frame, StageTimes* times);
  void Apply(const WorldCorrection& correction, int frame_index);
  PreparedFrame Prepare(const RgbdFrame& frame, const CameraMotion& motion, StageTimes* times);
  Prediction Predict(const PreparedFrame& frame, StageTimes* times);
  void PredictAhead(const RgbdFrame& frame, StageTimes* times);
  Tracked Track(const PreparedFrame& frame, const Prediction& prediction, StageTimes* times);
  FrameReport ReportDuplicate(const RgbdFrame& frame, const StageTimes& times);
  FrameReport Integrate(PreparedFrame frame, Tracked tracked, StageTimes* times);
  std::optional<PosedFrame> AddConfirmed(const Tracked& tracked);
  void Fuse(const PreparedFrame& frame, const Tracked& tracked, FrameReport* report,
            StageTimes* times);
  bool IsHeldOut(const Tracked& tracked) const;
  // The back end, if frames are added to it: null without loops and calibration, and for
  // localisation.
  Backend* keeper() const { return use_ == StateUse::kLocalize ? nullptr : backend_.get(); }

  const DepthSensor sensor_;  // as given
  const SlamOptions options_;
  const StateUse use_;
  std::unique_ptr<FramePreparation> preparation_;
  std::unique_ptr<Mapper> mapper_;
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<Backend> backend_;          // null without loops and calibration
  std::unique_ptr<Relocalizer> relocalizer_;  // null without loops
  int frame_count_ = 0;
  std::function<void(const FrameReport&)> on_pose_;
};

}  // namespace surfit
