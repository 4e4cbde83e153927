#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/move_map.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/loop_finder.h"
#include "surfit/slam/loop_options.h"
#include "surfit/slam/posed_frame.h"

namespace surfit {

class LoopThread;
struct LoopOutcome;
struct NewKeyframe;

// What changes in the world when loops have been closed.
struct WorldCorrection {
  bool moves = false;            // else the corrections are all the identity
  FrameCorrections corrections;  // of what the frames saw
  Rigid3d new_from_old_now;      // of the camera, and of frames to come
  std::vector<int> joined;       // the earlier keyframes' frames of new loops
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

// Closes loops while the camera is tracked: chooses keyframes, looks for loops and optimises the
// pose graph on a thread of its own, one task at a time, where there may be more than one. What
// comes of a task takes effect LoopOptions::delay_frames frames after it was begun, at any number
// of threads.
class Backend {
 public:
  // Throws InputError for bad options.
  explicit Backend(const LoopOptions& options, LoopFinder finder = {});
  ~Backend();

  // To be called before each frame: what takes effect there.
  std::optional<WorldCorrection> BeginFrame();

  // To be called after each frame that has a pose: it may become a keyframe.
  void AddFrame(int index, double stamp_s, const Rigid3d& world_from_camera, const IcpResult& icp,
                const FramePyramid& pyramid, const Image<Rgb8>& color);
  // The same of a frame at the last one's pose, which never becomes one.
  void AddFrozenFrame(int index, double stamp_s);

  // Looks for a view among all keyframes; waits for the task under way.
  Relocalization Find(const ColoredView& view);
  // The next frame is joined to the keyframe that it was found by.
  void AfterRelocalization(int keyframe);
  // The next frame begins a map apart from the others, at the pose that is returned: it stands
  // kSubmapDistance beside them until a loop joins it to them.
  static constexpr double kSubmapDistance = 50;  // metres
  Rigid3d BeginSubmap(const Rigid3d& world_from_last);

  // What is still to be done after the last frame, and to take effect; nothing once all has.
  std::optional<WorldCorrection> Finish();

  BackendCounts counts() const;
  const std::vector<LoopRecord>& loops() const { return loops_; }
  // All frames with a pose, in their order, as corrected so far.
  const std::vector<PosedFrame>& frames() const { return frames_; }
  Trajectory trajectory() const;
  int FrameOfKeyframe(int keyframe) const { return frames_[frame_of_keyframe_[keyframe]].index; }

 private:
  bool BecomesKeyframe(const PosedFrame& frame, const FramePyramid& pyramid) const;
  void AddKeyframe(const IcpResult& icp, const FramePyramid& pyramid, const Image<Rgb8>& color);
  std::vector<Rigid3d> KeyframePoses() const;
  void StartTask();
  std::optional<WorldCorrection> Apply(const LoopOutcome& outcome);
  void UpdateLoops(const LoopOutcome& outcome);
  std::vector<int> NewlyJoined(const LoopOutcome& outcome) const;
  std::vector<Rigid3d> CorrectionsOfKeyframes(const LoopOutcome& outcome) const;
  std::size_t SubmapsApart() const;

  LoopOptions options_;
  std::vector<PosedFrame> frames_;
  std::vector<int> frame_of_keyframe_;   // positions in frames_
  std::vector<int> parent_of_keyframe_;  // the one that its edge of odometry leads from, or -1
  std::vector<int> submap_of_keyframe_;
  std::optional<Keyframe> last_keyframe_;  // with a view to measure overlap by
  std::vector<NewKeyframe> waiting_;       // for a task
  std::unique_ptr<LoopThread> thread_;
  int frames_since_start_ = 0;  // of its task
  std::optional<int> anchor_;   // keyframe that the next frame is joined to
  bool begins_submap_ = true;
  int stretch_ = -1;
  int submap_ = -1;
  std::vector<LoopRecord> loops_;
  BackendCounts counts_;
};

}  // namespace surfit
