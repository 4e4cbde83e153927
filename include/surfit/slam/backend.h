#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/loop_closure/find_loops.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/mapping/move_map.h"
#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/optimization/refine.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

class OptionVisitor;

// What registrations do not know of their errors. The covariance of odometry is what they say,
// times the points that share one error and the frames between the keyframes: drift is a walk at
// random, and goes above all where a view holds the camera least. Errors of calibration and of
// surfaces that are not what the model of noise says do not average out at all: they are added to
// the covariance of every edge of the pose graph, as standard deviations of each component.
struct EdgeNoise {
  double shared_points = kSharedPoints;
  double odometry_m = 0.0002;     // between consecutive keyframes, and
  double odometry_rad = 0.0001;   //
  double odometry_share = 0.001;  // of the way and of the turn between them
  double loop_m = 0.003;          // of a loop, beyond FarVerdict::information
  double loop_rad = 0.0015;

  void Visit(OptionVisitor& visitor);
};

// Few surfels and rounds: a camera has few numbers, and is found again soon.
inline RefinementOptions CoarseRefinementOptions() {
  RefinementOptions options;
  options.cells_across = 40;
  options.max_rounds = 3;
  options.kernel_growth = 2;
  return options;
}

// Of loops: wrong ones are left out.
inline PoseGraphOptions RobustPoseGraphOptions() {
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  return options;
}

// How loops are closed, and how a lost camera is found again.
struct LoopOptions {
  bool enabled = false;
  KeyframeOptions keyframes;
  PlaceViewOptions views;
  PlaceIndexOptions places;
  FindLoopsOptions find;
  RelocalizeOptions relocalize;
  EdgeNoise noise;
  PoseGraphOptions graph = RobustPoseGraphOptions();
  // What is found out from a keyframe on takes effect before the so-many-th frame after it, however
  // long it takes: the same on every machine.
  int delay_frames = 30;
  // FusionOptions::active_frames where loops are closed and that sets no limit: what the camera has
  // drifted from must not hold it until a loop has put both together. 0 = no limit either.
  int active_frames = 200;
  // Surfels last seen longer before others were first seen are merged with these where a loop puts
  // them together; FusionOptions::active_frames where that is more.
  int frames_apart = 100;
  // A correction that moves no keyframe farther is not applied: the map is as good as it was.
  double min_correction_m = 0.002;
  std::size_t max_view_bytes = std::size_t{512} << 20;  // of keyframes: LimitKeyframes()
  // After so many lost frames in a row a new map is begun, and joined to the first by a loop. 0 =
  // never.
  int new_map_after = 0;

  void Visit(OptionVisitor& visitor);
};

// How the depth camera is calibrated while it is tracked: by Refine() of all keyframes so far, when
// there are first_keyframes, and each time there are a quarter more. What n keyframes tell takes
// effect 1 + n/2 + n^2/40 frames later, however long it takes: the same on every machine. What is
// no other than the given calibration, as far as the covariance tells, changes nothing.
struct CalibrationOptions {
  bool enabled = true;
  int first_keyframes = 4;
  int max_keyframes = 45;  // beyond this the camera stays as it was found
  RefinementOptions refinement = CoarseRefinementOptions();

  void Visit(OptionVisitor& visitor);
};

// A frame that has a pose, and what it hangs on.
struct PosedFrame {
  int index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;  // as corrected so far
  int keyframe = 0;           // the last one before it, or itself
  // Frames of one stretch were tracked one after the other; relocalisation begins another one.
  int stretch = 0;
};

// Tries to join keyframe `source` to earlier ones: FindLoops(), or another way.
using LoopFinder = std::function<std::vector<LoopAttempt>(
    int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index)>;

// A pair of keyframes that was tried as a loop, by the frames' indices.
struct LoopRecord {
  int source_frame = 0, target_frame = 0;
  LoopAttempt attempt;
  bool in_graph = false;  // accepted, and consistent with the others when last looked at
  bool is_kept = false;   // of a SlamState: of the attempt, the pair and the verdict are known
};

// A keyframe's view, made by whichever thread asks for it first.
using ViewOfKeyframe = std::function<PlaceView()>;

// To be called with each new keyframe: with its frame's index, its view, and what the camera is
// calibrated by, if it is.
using KeyframeCall = std::function<void(int frame, const ViewOfKeyframe& view,
                                        const std::shared_ptr<const RgbdFrame>& calibration_frame)>;

class Calibrator;
class LoopCloser;
struct SlamState;
enum class StateUse;
struct LoopOutcome;
struct NewKeyframe;

// What changes in the world when loops have been closed, or the camera has been calibrated.
struct WorldCorrection {
  bool moves = false;                            // else the corrections are all the identity
  FrameCorrections corrections{0, {Rigid3d()}};  // of what the frames saw
  Rigid3d new_from_old_now;                      // of the camera, and of frames to come
  std::vector<int> joined;                       // the earlier keyframes' frames of new loops
  std::optional<Recalibration> recalibration;  // frames are seen by another calibration from now on
};

// A calibration that was found while the camera was tracked.
struct CalibrationRecord {
  std::size_t keyframes = 0;
  int begun_frame = 0;  // the last of them
  int frame = 0;        // the last one before it took effect
  RefinementSummary summary;
  ColorLatency color_latency;  // beyond the given one
};

// A keyframe's place in the pose graph, by frames' indices.
struct KeyframeLink {
  int frame = 0;
  int parent_frame =
      kNone;       // the keyframe's that odometry, or finding the camera again, leads from
  int submap = 0;  // that it was begun in

  static constexpr int kNone = -1;
};

// What the backend has done.
struct BackendCounts {
  std::size_t keyframes = 0;
  std::size_t loops_proposed = 0;  // pairs of keyframes that were looked at
  std::size_t loops_accepted = 0;  // of these, verified and consistent with the others
  std::size_t loops_refused = 0;   // all others: LoopRecord tells why
  std::size_t corrections = 0;     // of the world
  std::size_t relocalisations = 0;
  std::size_t submaps = 0;         // begun, the first included
  std::size_t submaps_apart = 0;   // of these, that no loop joins to the first
  std::size_t waits = 0;           // corrections that were due before they were ready
  std::size_t given_up_views = 0;  // of keyframes, for want of LoopOptions::max_view_bytes
};

// Keeps the frames' poses and chooses keyframes while the camera is tracked. With loops enabled,
// looks for them and optimises the pose graph; with calibration enabled, finds the depth camera's:
// each on a thread of its own, one task at a time, where there may be more than one. What comes of
// a task takes effect a number of frames after it was begun that no machine has a say in; in real
// time, with the first frame from that one on that does not have to wait for it.
class Backend {
 public:
  // The sensor is as given. Throws InputError for bad options.
  Backend(const DepthSensor& sensor, const PreprocessOptions& preprocess, const LoopOptions& loops,
          const CalibrationOptions& calibration, LoopFinder finder = {}, bool real_time = false);
  ~Backend();

  // Takes up what another one has known; with loops enabled, before the first frame. All of the
  // state but its map and the last keyframe's view is moved from.
  void GoOnFrom(SlamState* state, StateUse use);
  void OnKeyframe(KeyframeCall call) { on_keyframe_ = std::move(call); }

  // To be called before each frame: what takes effect there, one after the other.
  std::vector<WorldCorrection> BeginFrame();

  // To be called after each frame that has a pose: it may become a keyframe. The frame is as it was
  // measured, the pyramid as it is by calibration().
  void AddFrame(const RgbdFrame& frame, const Rigid3d& world_from_camera, const IcpResult& icp,
                const FramePyramid& pyramid);
  // The same of a frame at the last one's pose, which never becomes one.
  void AddFrozenFrame(int index, double stamp_s);

  // Leaves the camera as it was found so far.
  void EndCalibration();

  // Looks for a view among all keyframes; waits for the task under way.
  Relocalization Find(const ColoredView& view);
  // The next frame is joined to the keyframe that it was found by.
  void AfterRelocalization(int keyframe);
  // The next frame begins a map apart from the others, at the pose that is returned: it stands
  // kSubmapDistance beside them until a loop joins it to them.
  static constexpr double kSubmapDistance = 50;  // metres
  Rigid3d BeginSubmap(const Rigid3d& world_from_last);

  // What is still to be done after the last frame, and to take effect, one after the other.
  std::vector<WorldCorrection> Finish();

  // What frames are to be seen by, null without calibration; and how it was found.
  const DepthCalibration* calibration() const;
  bool is_recalibrated() const;  // that is not as given
  bool is_calibrating() const;   // more keyframes may change it
  // By how much colour is earlier than frames have it.
  double color_latency_s() const;
  const std::vector<CalibrationRecord>& calibrations() const { return calibrations_; }

  BackendCounts counts() const;
  const std::vector<LoopRecord>& loops() const { return loops_; }
  // All frames with a pose, in their order, as corrected so far.
  const std::vector<PosedFrame>& frames() const { return frames_; }
  Trajectory trajectory() const;
  int FrameOfKeyframe(int keyframe) const { return frames_[frame_of_keyframe_[keyframe]].index; }
  std::vector<KeyframeLink> keyframes() const;
  // The same with their views. After Finish(), with loops enabled.
  std::vector<Keyframe> keyframe_views() const;
  // What was measured between keyframes: odometry, and all loops that were accepted, wrong ones
  // too; and of these, whether they are consistent with the others.
  const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  std::vector<bool> loops_in_graph() const;
  // The first so many keyframes have been looked at for loops.
  std::size_t settled_keyframes() const;

 private:
  bool BecomesKeyframe(const PosedFrame& frame, const FramePyramid& pyramid) const;
  void AddKeyframe(const RgbdFrame& frame, const IcpResult& icp, const FramePyramid& pyramid);
  void TakeLinks(const std::vector<KeyframeLink>& links);
  void TakeKeyframes(std::vector<PlaceView> views, std::size_t settled);
  std::optional<PoseGraphEdge> EdgeTo(const PosedFrame& keyframe, int parent,
                                      const IcpResult& icp) const;
  std::vector<Rigid3d> KeyframePoses() const;
  void StartTask();
  void StartTaskIfFree();
  void StartCalibration();
  void TakeLoops(std::vector<WorldCorrection>* corrections);
  void FinishLoops(std::vector<WorldCorrection>* corrections);
  void TakeCalibration(std::vector<WorldCorrection>* corrections);
  // Moves all frames by those of keyframes.
  WorldCorrection Move(const std::vector<Rigid3d>& new_from_old_of_keyframe);
  void UpdateLoops(const LoopOutcome& outcome);
  std::vector<int> NewlyJoined(const LoopOutcome& outcome) const;
  std::vector<Rigid3d> CorrectionsOfKeyframes(
      const std::vector<Rigid3d>& world_from_keyframe) const;
  std::size_t SubmapsApart() const;

  LoopOptions options_;
  bool real_time_;
  std::vector<PosedFrame> frames_;
  std::vector<int> frame_of_keyframe_;   // positions in frames_
  std::vector<int> parent_of_keyframe_;  // that its edge of odometry leads from, or kNone
  std::vector<int> submap_of_keyframe_;
  std::optional<Keyframe> last_keyframe_;  // with a view to measure overlap by
  std::vector<NewKeyframe> waiting_;       // for a task
  std::size_t in_task_ = 0;                // keyframes of the one that is under way
  std::vector<PoseGraphEdge> edges_;       // as the closer has them, and those of waiting ones
  KeyframeCall on_keyframe_;
  std::unique_ptr<LoopCloser> closer_;  // null without loops
  std::unique_ptr<Calibrator> calibrator_;
  std::vector<CalibrationRecord> calibrations_;
  std::optional<int> anchor_;  // keyframe that the next frame is joined to
  bool begins_submap_ = true;
  int stretch_ = -1;
  int submap_ = -1;
  std::vector<LoopRecord> loops_;
  BackendCounts counts_;
};

}  // namespace surfit
