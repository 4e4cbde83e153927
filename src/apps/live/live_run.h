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

// Limits the rate of a periodic task: at least min_gap_s between two calls, and at most the ratio
// `share` of the time, from 0 (exclusive) to 1. `must` ignores both limits. Not thread-safe.
class RateLimiter {
 public:
  RateLimiter(double min_gap_s, double share) : min_gap_(min_gap_s), share_(share) {}

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

// Advice for the camera operator.
struct Advice {
  std::string kind;  // "lost", "too_fast", "too_close", "little_depth", "little_shape" or "moving"
  std::string text;
};

// Advice for a frame; empty: none. `world_from_camera_before`: pose of the previous frame; null:
// none.
std::vector<Advice> Advise(const SlamRunFrame& frame, const Rigid3d* world_from_camera_before);

// Camera positions at both ends of a loop closure, in the world frame.
struct LoopSegment {
  Eigen::Vector3d a, b;
};

// Viewer of a run, for example a web page. The thread of the run calls these functions. Order:
// Show() and Wait() per frame, ShowWork(), Keep(), Stay().
class RunViewer {
 public:
  virtual ~RunViewer() = default;
  // Called after each frame.
  virtual void Show(const SlamRunFrame& frame) = 0;
  // Called repeatedly while the run is paused after this frame. Blocks for about wait_ms.
  virtual void Wait(const SlamRunFrame& frame, int wait_ms) = 0;
  // Called during refinement and re-integration.
  virtual void ShowWork() = 0;
  // Called once with the final results, after the last ShowWork().
  virtual void Keep(const SlamRunResult& result) = 0;
  // Blocks until the result is no longer viewed.
  virtual void Stay() = 0;
};

// State of a run for its viewers, which can pause and stop the run. A pause does not change the
// results.
class LiveRun {
 public:
  // `interrupted` must outlive the LiveRun. `interrupt` must set `interrupted` and be
  // thread-safe.
  LiveRun(const std::atomic<bool>& interrupted, std::function<void()> interrupt);

  // Call before the run.
  void Add(std::unique_ptr<RunViewer> viewer) { viewers_.push_back(std::move(viewer)); }

  // Callbacks of RunSlam(). Update() blocks while the run is paused. It does nothing without
  // viewers.
  void Update(const SlamRunProgress& progress);
  void Keep(const SlamRunResult& result);
  // Call at the end. Returns at once before Keep() and after an interruption.
  void Stay();

  // Control by viewers, thread-safe. After the last frame, the run is not paused.
  void Pause() { pauses_ = true; }
  void GoOn() { pauses_ = false; }
  void Step();  // processes one frame, then pauses
  // Interrupts the run once. Does nothing after an interruption.
  void Stop();
  bool is_paused() const { return pauses_ && !is_at_result_; }
  bool is_interrupted() const { return interrupted_; }
  bool MayContinue() const { return !pauses_ || steps_ || interrupted_; }

  // Functions for the thread of the run only.
  const SlamRunProgress& progress() const { return progress_; }  // without frame
  FrameState state() const { return state_; }
  bool is_lost() const { return state_ == FrameState::kLost; }
  bool is_at_result() const { return is_at_result_; }  // since refinement, re-integration or Keep()
  bool is_done() const { return is_done_; }            // after Keep()
  double frames_per_second() const { return frame_s_ > 0 ? 1 / frame_s_ : 0; }  // running mean
  const std::vector<Advice>& advice() const { return advice_; }
  const Trajectory& path() const { return path_; }  // with all corrections so far
  const std::vector<LoopSegment>& loops() const { return loops_; }
  // frame indices
  const std::optional<std::pair<int, int>>& last_loop() const { return last_loop_; }
  // Colour of the last frame with a pose; empty: none.
  const Image<Rgb8>& last_good() const { return last_good_; }
  // State of the run in one line.
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
  std::array<std::size_t, 3> corrections_{};  // numbers of corrections in path_ and loops_
  std::vector<LoopSegment> loops_;
  std::optional<std::pair<int, int>> last_loop_;
  std::optional<Rigid3d> last_pose_;  // pose of the last frame; std::nullopt: lost
  Image<Rgb8> last_good_;
  double frame_s_ = 0;  // running mean, without the time of the viewers
  Clock::time_point left_ = Clock::now();
  // Last member: their threads use the members above.
  std::vector<std::unique_ptr<RunViewer>> viewers_;
};

}  // namespace surfit
