#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "surfit/calibration/calibration.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/mapping/move_map.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// State of SLAM with loops enabled, after a frame. Another Slam can continue from it.
struct SlamState : StoredPoses {
  // Views of the keyframes. A view is empty if it was removed to limit memory, or is not ready.
  // Relocalisation does not use empty views.
  std::vector<PlaceView> views;
  std::optional<DepthCalibration> calibration;  // std::nullopt: input calibration
  double color_latency_s = 0;                   // in addition to RgbdCamera::color_latency_s
  // Keyframes for calibration; empty if the calibration has ended.
  std::vector<std::shared_ptr<const RgbdFrame>> calibration_frames;
  SurfelMap map;
};

// Use of a saved state.
enum class StateUse {
  kContinue,  // map, poses and keyframes grow
  kLocalize   // localise the camera only; map and poses do not change
};

// Callback for each new keyframe, on the thread of Slam. `calibration_frame` is null without
// calibration.
using KeyframeCall = std::function<void(int frame, const ViewOfKeyframe& view,
                                        const std::shared_ptr<const RgbdFrame>& calibration_frame)>;

class Calibrator;
class LoopCloser;
struct LoopOutcome;
struct KeyframeForLoops;

// Correction of the world frame by loop closures or a calibration.
struct WorldCorrection {
  bool moves = false;                            // false: the corrections are the identity
  FrameCorrections corrections{0, {Rigid3d()}};  // per frame
  Rigid3d new_from_old_now;                      // for the camera pose and later frames
  std::vector<int> joined;                       // target frames of new loops
  std::optional<Recalibration> recalibration;    // change of the calibration for later frames
};

// Statistics of the back end.
struct BackendCounts {
  std::size_t keyframes = 0;
  std::size_t loop_candidates = 0;  // loop candidates
  std::size_t loops_accepted = 0;   // verified loops that are no outliers
  std::size_t loops_rejected = 0;   // rejected candidates and outliers: LoopRecord has the reason
  std::size_t corrections = 0;      // corrections of the world frame
  std::size_t relocalisations = 0;
  std::size_t submaps = 0;               // including the first
  std::size_t disconnected_submaps = 0;  // submaps that no loop connects to the first submap
  std::size_t waits = 0;                 // corrections that were not ready in time
  std::size_t removed_views = 0;         // keyframe views removed by LoopOptions::max_view_bytes
};

// Back end: adds frames to the pose store, selects keyframes, and applies the results of loop
// closure and calibration tasks. Each kind of task runs in its own thread if more than one thread
// may compute, one task at a time. A result is applied a fixed number of frames after the start of
// its task, so that results do not depend on the machine. In real time, a late result does not
// block: it is applied at the first frame after the task has finished.
//
// Not thread-safe.
class Backend {
 public:
  // `sensor` is the input sensor. An empty `finder` is FindLoops(). Throws InputError for invalid
  // options.
  Backend(const DepthSensor& sensor, const PreprocessOptions& preprocess, const LoopOptions& loops,
          const CalibrationOptions& calibration, LoopFinder finder = {}, bool real_time = false);
  ~Backend();

  // Continues from a state. Requires enabled loops. Call before the first frame. Moves from the
  // state, except from its map.
  void ContinueFrom(SlamState* state, StateUse use);
  // Sets the callback for new keyframes. Requires enabled loops.
  void OnKeyframe(KeyframeCall call) { on_keyframe_ = std::move(call); }

  // Call before each frame. Returns the corrections to apply before this frame, in order. Waits for
  // a task whose result is due, except in real time. Throws the exception of a failed task.
  std::vector<WorldCorrection> BeginFrame();

  // Call after each frame with a pose. `frame` has the measured images. `pyramid` uses the
  // estimated calibration.
  void AddFrame(const RgbdFrame& frame, const Rigid3d& world_from_camera, const IcpResult& icp,
                const FramePyramid& pyramid);
  // Adds a duplicate frame at the pose of the last frame. It never becomes a keyframe.
  void AddDuplicateFrame(int index, double stamp_s);

  // Ends calibration. The current estimate stays.
  void EndCalibration();

  // Searches all keyframes for a view. Waits for the current loop task. Requires enabled loops.
  Relocalization Find(const ColoredView& view);
  // Connects the next frame to the keyframe of its relocalisation.
  void AfterRelocalization(int keyframe);
  // Starts a new submap with the next frame. Returns the pose of this frame: kSubmapDistance beside
  // the other submaps, with the rotation of `world_from_last`.
  static constexpr double kSubmapDistance = 50;  // metres
  Rigid3d BeginSubmap(const Rigid3d& world_from_last);

  // Waits for all tasks after the last frame. Returns their corrections, in order.
  std::vector<WorldCorrection> Finish();

  // Frames, keyframes, edges and loops. The reference is valid until the Backend is destroyed.
  const PoseStore& poses() const { return poses_; }
  // Keyframes with their views. Call after Finish(), with enabled loops.
  std::vector<Keyframe> keyframe_views() const;
  // Number of keyframes with a completed loop search.
  std::size_t settled_keyframes() const;

  // Current calibration; null without calibration.
  const DepthCalibration* calibration() const;
  bool is_recalibrated() const;  // the calibration differs from the input
  bool is_calibrating() const;   // further keyframes can change the calibration
  // Estimated colour latency in addition to RgbdCamera::color_latency_s, s.
  double color_latency_s() const;
  const std::vector<CalibrationRecord>& calibrations() const { return calibrations_; }

  BackendCounts counts() const;

 private:
  void AddKeyframe(const RgbdFrame& frame, const IcpResult& icp, const FramePyramid& pyramid);
  bool BecomesKeyframe(int frame_index, const Rigid3d& world_from_camera,
                       const FramePyramid& pyramid);
  void TakeViews(std::vector<PlaceView> views, std::size_t settled);
  std::optional<PoseGraphEdge> EdgeTo(const PosedFrame& keyframe, int parent,
                                      const IcpResult& icp) const;
  void StartLoopTask();
  void StartLoopTaskIfFree();
  void StartCalibration();
  void TakeLoops(std::vector<WorldCorrection>* corrections);
  void FinishLoops(std::vector<WorldCorrection>* corrections);
  void TakeCalibration(std::vector<WorldCorrection>* corrections);
  // Moves all frames with their keyframes.
  WorldCorrection Move(const std::vector<Rigid3d>& new_from_old_of_keyframe);
  std::vector<Rigid3d> CorrectionsOfKeyframes(
      const std::vector<Rigid3d>& world_from_keyframe) const;

  LoopOptions options_;
  bool real_time_;
  PoseStore poses_;
  std::optional<Keyframe> last_keyframe_;  // its view measures the overlap with new frames
  std::vector<KeyframeForLoops> waiting_;  // for the next loop task
  std::size_t in_task_ = 0;                // number of new keyframes in the current loop task
  std::optional<int> anchor_;              // keyframe that the next frame is connected to
  bool begins_submap_ = true;
  KeyframeCall on_keyframe_;
  std::unique_ptr<LoopCloser> closer_;      // null without loops
  std::unique_ptr<Calibrator> calibrator_;  // null without calibration
  std::vector<CalibrationRecord> calibrations_;
  BackendCounts counts_;
};

}  // namespace surfit
