#pragma once

#include <Eigen/Geometry>
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

// State of a Slam with loop closure, after a frame. Another Slam can continue from the state.
struct SlamState : StoredPoses {
  // Views by keyframe. A view is empty if it is not ready, or was removed to limit memory.
  // Relocalisation does not use empty views.
  std::vector<PlaceView> views;                 // one per keyframe
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

// Callback for a new keyframe, called by the thread of Slam::Process(). `frame` is the frame index.
// `calibration_frame` is null without calibration, or after calibration has ended.
using KeyframeCall = std::function<void(int frame, const ViewOfKeyframe& view,
                                        const std::shared_ptr<const RgbdFrame>& calibration_frame)>;

// Motion between two frames by another source than registration. Covariances (rad, m) are of left
// increments, in frame b.
struct PriorEdge {
  // Poses of both cameras in the world of the source.
  Rigid3d source_from_a, source_from_b;
  Matrix6d covariance;  // of the motion by the source
  // Covariance of the registered motion, in addition to that of the odometry edge.
  Matrix6d odometry_covariance;
  Matrix6d registration_noise;  // of one registered pose
};
// Returns std::nullopt without a motion between both times (s), or with a rejected one.
using PriorMotions = std::function<std::optional<PriorEdge>(double a_s, double b_s)>;

class Calibrator;
class LoopCloser;
struct LoopOutcome;
struct KeyframeForLoops;

// Correction of the world frame by loop closures or a calibration. The caller moves the map
// (MoveMap()) and its own poses; the poses of the Backend are already corrected.
struct WorldCorrection {
  bool moves = false;                            // false: the corrections are the identity
  FrameCorrections corrections{0, {Rigid3d()}};  // by frame index
  Rigid3d new_from_old_now;  // correction of the camera pose and of later frames
  std::vector<int> joined;   // indices of the target frames of new loops
  // Piece of each submap: see PoseStore. Submaps of one piece have a common map.
  std::vector<int> piece_of_submap;
  std::optional<Recalibration> recalibration;  // change of the calibration for later frames
};

// Counts since construction, or since Backend::ContinueFrom() for corrections, relocalisations,
// waits and removed views. Other counts include the continued state.
struct BackendCounts {
  std::size_t keyframes = 0;
  std::size_t loop_candidates = 0;
  std::size_t loops_accepted = 0;  // verified loops without outliers
  std::size_t loops_rejected = 0;  // rejected candidates and outliers: see LoopRecord
  std::size_t corrections = 0;
  std::size_t relocalisations = 0;
  std::size_t submaps = 0;               // including the first
  std::size_t disconnected_submaps = 0;  // submaps without a loop to the first submap
  std::size_t waits = 0;                 // results that tracking had to wait for
  std::size_t removed_views = 0;         // keyframe views removed by LoopOptions::max_view_bytes
};

// Back end: stores poses, selects keyframes, and applies the results of background tasks. Loop
// closure and calibration each run one task at a time, in a thread of their own. With one computing
// thread, tasks run in the calling thread unless `real_time` is true. Results are applied a fixed
// number of frames after the task starts, so they do not depend on the machine. In real time, a
// late result is applied at the first frame after the task has finished.
//
// Not thread-safe.
class Backend {
 public:
  // `sensor` is the input sensor. An empty `finder` stands for FindLoops(). Throws InputError for
  // invalid loop options. Other arguments are not checked.
  Backend(const DepthSensor& sensor, const PreprocessOptions& preprocess, const LoopOptions& loops,
          const CalibrationOptions& calibration, LoopFinder finder = {}, bool real_time = false);
  ~Backend();

  // Continues from a state. Requires LoopOptions::HasViews(), and a state with a keyframe and one
  // view per keyframe. Call before the first frame. Moves from all members of the state except its
  // map.
  void ContinueFrom(SlamState* state, StateUse use);
  // Sets the callback for new keyframes; null: none. Not called without loops.
  void OnKeyframe(KeyframeCall call) { on_keyframe_ = std::move(call); }

  // Adds motions of another source to the pose graph, between consecutive keyframes,
  // and after the last frame between consecutive frames.
  void UsePriorMotions(PriorMotions motions) { prior_motions_ = std::move(motions); }

  // Call before each frame. Returns the corrections to apply before this frame, in order; empty
  // without corrections. Waits for a task whose result is due, except in real time. Throws the
  // exception of a failed task.
  std::vector<WorldCorrection> BeginFrame();

  // Call after each frame with a pose. `frame` has the measured images. `icp` is the registration
  // of the frame; it gives the information of the edge of a keyframe. `pyramid` has surfaces in the
  // camera frame, computed with the estimated calibration.
  void AddFrame(const RgbdFrame& frame, const Rigid3d& world_from_camera, const IcpResult& icp,
                const FramePyramid& pyramid);
  // Adds a duplicate frame with the pose of the last frame. Requires a last frame. The duplicate
  // never becomes a keyframe.
  void AddDuplicateFrame(int index, double stamp_s);

  // Ends calibration: waits for a running task and drops its result. The current estimate stays.
  void EndCalibration();

  // Relocalises a view by one of the most similar keyframes: RelocalizeOptions::first_candidate is
  // `rank`. Waits for the current loop task. In real time, finds nothing during a task. Requires
  // LoopOptions::HasViews().
  Relocalization Find(const ColoredView& view, int rank);
  // Registers a view to the view of an earlier frame, as for a loop closure. Requires
  // LoopOptions::HasViews().
  GlobalRegistrationResult RegisterTo(const ColoredView& earlier, const ColoredView& view) const;
  // Call after a relocalisation. The next frame becomes a keyframe with an edge to `keyframe`.
  void AfterRelocalization(int keyframe);
  // Starts a new submap with the next frame, and returns the number of the submap. Its poses have a
  // world frame of their own, until a loop closure connects the submap to another submap.
  int BeginSubmap();

  // Waits for all tasks after the last frame. Returns their corrections, in order. Throws the
  // exception of a failed task.
  std::vector<WorldCorrection> Finish();

  // Replaces the poses of all frames of poses(), in their order. Requires at least one frame.
  WorldCorrection MoveFrames(const std::vector<Rigid3d>& world_from_frame);

  // Moves pieces that no loop closure has connected beside each other, along x, so that their boxes
  // are at least 1 m apart. The first piece stays. `boxes`: boxes of the maps in world
  // coordinates, by submap. Call after Finish(). Returns std::nullopt with one piece.
  std::optional<WorldCorrection> PlacePieces(const std::vector<Eigen::AlignedBox3d>& boxes);

  // Frames, keyframes, edges and loops. The reference is valid until the Backend is destroyed.
  const PoseStore& poses() const { return poses_; }
  // Keyframes with their views, by keyframe. Call after Finish(). Requires LoopOptions::HasViews().
  std::vector<Keyframe> keyframe_views() const;
  // Number of keyframes with a completed loop search.
  std::size_t settled_keyframes() const;

  // Current calibration; null without calibration. The pointer is valid until the Backend is
  // destroyed.
  const DepthCalibration* calibration() const;
  bool is_recalibrated() const;  // the calibration differs from the input
  bool is_calibrating() const;   // further keyframes can change the calibration
  // Estimated colour latency in addition to RgbdCamera::color_latency_s, s; 0 without calibration.
  double color_latency_s() const;
  const std::vector<CalibrationRecord>& calibrations() const { return calibrations_; }

  // Counts until now.
  BackendCounts counts() const;

 private:
  void AddKeyframe(const RgbdFrame& frame, const IcpResult& icp, const FramePyramid& pyramid);
  bool BecomesKeyframe(int frame_index, const Rigid3d& world_from_camera,
                       const FramePyramid& pyramid);
  void TakeViews(std::vector<PlaceView> views, std::size_t settled);
  InverseDepthField Field() const;  // of the current calibration
  void AddEdgeTo(const PosedFrame& keyframe, int parent, const IcpResult& icp);
  void StartLoopTask();
  void StartLoopTaskIfFree();
  void StartCalibration();
  void TakeLoops(std::vector<WorldCorrection>* corrections);
  void FinishLoops(std::vector<WorldCorrection>* corrections);
  void TakeCalibration(std::vector<WorldCorrection>* corrections);
  PoseGraph Graph(const std::vector<Rigid3d>& world_from_keyframe);
  void FusePriorMotions(std::vector<WorldCorrection>* corrections);
  std::optional<std::vector<Rigid3d>> KeyframesWithPrior();
  std::vector<Rigid3d> SmoothedByPrior(std::vector<Rigid3d> world_from_frame) const;
  WorldCorrection Move(const std::vector<Rigid3d>& new_from_old_of_keyframe);
  std::vector<Rigid3d> CorrectionsOfKeyframes(
      const std::vector<Rigid3d>& world_from_keyframe) const;

  LoopOptions options_;
  bool real_time_;
  PoseStore poses_;
  std::optional<Keyframe> last_keyframe_;  // with a view, for the overlap with new frames
  std::vector<KeyframeForLoops> waiting_;  // for the next loop task
  std::size_t in_task_ = 0;                // new keyframes in the current loop task
  std::optional<int> anchor_;              // keyframe that relocalised the next frame
  bool begins_submap_ = true;
  KeyframeCall on_keyframe_;
  PriorMotions prior_motions_;              // empty: none
  std::unique_ptr<LoopCloser> closer_;      // null without loops
  std::unique_ptr<Calibrator> calibrator_;  // null without calibration
  std::vector<CalibrationRecord> calibrations_;
  BackendCounts counts_;
};

}  // namespace surfit
