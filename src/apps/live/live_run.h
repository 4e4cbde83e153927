#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// How often a thing is done again beside the run: not more often than every min_gap_s, and so
// seldom that it takes no more than a share of the time.
class Pace {
 public:
  Pace(double min_gap_s, double share) : min_gap_(min_gap_s), share_(share) {}

  // Calls act() if it is time, or if it must be.
  template <typename Act>
  void ActIfDue(bool must, const Act& act) {
    const Clock::time_point begin = Clock::now();
    if (!must && begin < next_) return;
    act();
    const Clock::time_point end = Clock::now();
    const std::chrono::duration<double> gap = (1 / share_ - 1) * (end - begin);
    next_ = end + std::chrono::duration_cast<Clock::duration>(std::max(min_gap_, gap));
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::chrono::duration<double> min_gap_;
  double share_;
  Clock::time_point next_;
};

// What who holds the camera had better do.
struct Advice {
  std::string kind;  // lost, too_fast, too_close, little_depth, little_shape, moving
  std::string text;
};

// What a frame and its report give reason to. The pose of the frame before is null where it has
// none, or there is none.
std::vector<Advice> Advise(const SlamRunFrame& frame, const Rigid3d* world_from_camera_before);

// Where two cameras were that a loop joins, in the world.
struct LoopSegment {
  Eigen::Vector3d a, b;
};

// Who shows a run, as pages in browsers do. Called by the run's own thread, which waits.
class RunViewer {
 public:
  virtual ~RunViewer() = default;
  // After each frame.
  virtual void Show(const SlamRunFrame& frame) = 0;
  // Again and again while the run pauses after that frame, for about wait_ms.
  virtual void Wait(const SlamRunFrame& frame, int wait_ms) = 0;
  // While the result is made.
  virtual void ShowWork() = 0;
  // What the run has come to. Goes on being shown in Stay().
  virtual void Keep(const SlamRunResult& result) = 0;
  // Returns when nobody looks any more.
  virtual void Stay() = 0;
};

// A run while it goes on, as all who show it know it: told by RunSlam(), paused and stopped by
// viewers. It changes nothing of what the run computes.
class LiveRun {
 public:
  // `interrupted` ends a pause. `interrupt`, which any thread may call, is to set it: as Ctrl-C.
  LiveRun(const std::atomic<bool>& interrupted, std::function<void()> interrupt);

  // To be called before the run.
  void Add(std::unique_ptr<RunViewer> viewer) { viewers_.push_back(std::move(viewer)); }

  // For RunSlam(). Update() returns when the run is to go on.
  void Update(const SlamRunProgress& progress);
  void Keep(const SlamRunResult& result);
  // To be called when results have been told: returns when nobody looks any more.
  void Stay();

  // Any thread may call these. Nothing is paused once the last frame is done.
  void Pause() { pauses_ = true; }
  void GoOn() { pauses_ = false; }
  void Step();  // one frame, and pauses
  void Stop();
  bool is_paused() const { return pauses_ && !is_at_result_; }
  bool is_interrupted() const { return interrupted_; }
  bool MayGoOn() const { return !pauses_ || steps_ || interrupted_; }

  // The rest is for the run's own thread.
  const SlamRunProgress& progress() const { return progress_; }  // without its frame
  FrameState state() const { return state_; }                    // of the last frame
  bool is_lost() const { return state_ == FrameState::kLost; }
  bool is_at_result() const { return is_at_result_; }  // no more frames will come
  bool is_done() const { return is_done_; }
  double frames_per_second() const { return frame_s_ > 0 ? 1 / frame_s_ : 0; }  // lately
  const std::vector<Advice>& advice() const { return advice_; }
  const Trajectory& path() const { return path_; }  // as corrected so far
  const std::vector<LoopSegment>& loops() const { return loops_; }
  // The frames that the last loop joins.
  const std::optional<std::pair<int, int>>& last_loop() const { return last_loop_; }
  const Image<Rgb8>& last_good() const { return last_good_; }  // the last image with a known pose
  // One line on how far the run is.
  std::string Status() const;

 private:
  void Note(const SlamRunFrame& frame);
  void NotePath(const SlamRunFrame& frame);
  void NoteLoops(const Backend& backend);

  using Clock = std::chrono::steady_clock;
  const std::atomic<bool>& interrupted_;
  std::function<void()> interrupt_;
  std::atomic<bool> pauses_{false}, steps_{false}, stops_{false}, is_at_result_{false};
  bool is_done_ = false;
  SlamRunProgress progress_;
  FrameState state_ = FrameState::kFirst;
  std::vector<Advice> advice_;
  Trajectory path_;
  std::array<std::size_t, 3> corrections_{};  // that path and loops have
  std::vector<LoopSegment> loops_;
  std::optional<std::pair<int, int>> last_loop_;
  std::optional<Rigid3d> last_pose_;  // of the last frame
  Image<Rgb8> last_good_;
  double frame_s_ = 0;  // lately, without the time spent here
  Clock::time_point left_ = Clock::now();
  std::vector<std::unique_ptr<RunViewer>> viewers_;  // whose threads use what stands above
};

}  // namespace surfit
