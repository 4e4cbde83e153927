#include "apps/live/live_run.h"

#include <cstdio>
#include <map>

#include "surfit/core/error.h"
#include "surfit/slam/backend.h"

namespace surfit {

LiveRun::LiveRun(const std::atomic<bool>& interrupted, std::function<void()> interrupt)
    : interrupted_(interrupted), interrupt_(std::move(interrupt)) {}

void LiveRun::Update(const SlamRunProgress& progress) {
  if (viewers_.empty()) return;
  progress_ = progress;
  progress_.frame = nullptr;
  if (!progress.frame) {
    is_at_result_ = progress.frames_reintegrated > 0 || progress.refinement_rounds > 0;
    for (const auto& viewer : viewers_) viewer->ShowWork();
    left_ = Clock::now();
    return;
  }
  const SlamRunFrame& frame = *progress.frame;
  Note(frame);
  steps_ = false;
  for (const auto& viewer : viewers_) viewer->Show(frame);
  constexpr int kWait_ms = 30;
  while (!MayContinue()) {
    for (const auto& viewer : viewers_) viewer->Wait(frame, kWait_ms);
  }
  left_ = Clock::now();
}

void LiveRun::Keep(const SlamRunResult& result) {
  is_at_result_ = is_done_ = true;
  advice_.clear();
  path_ = result.trajectory;
  for (const auto& viewer : viewers_) viewer->Keep(result);
}

void LiveRun::Stay() {
  if (!is_done_ || is_interrupted()) return;
  for (const auto& viewer : viewers_) viewer->Stay();
}

void LiveRun::Step() {
  pauses_ = true;
  steps_ = true;
}

// Interrupts the run at most once. A second interruption could end the run without results.
void LiveRun::Stop() {
  if (!stops_.exchange(true) && !interrupted_) interrupt_();
}

void LiveRun::Note(const SlamRunFrame& frame) {
  constexpr double kNew = 0.1;  // weight of the newest frame in the mean
  const double seconds = std::chrono::duration<double>(Clock::now() - left_).count();
  frame_s_ = frame_s_ == 0 ? seconds : frame_s_ + kNew * (seconds - frame_s_);
  state_ = frame.report.state;
  advice_ = Advise(frame, last_pose_ ? &*last_pose_ : nullptr);
  last_pose_.reset();
  if (is_lost()) return;
  last_pose_ = frame.report.world_from_camera;
  last_good_ = frame.frame.color;
  NotePath(frame);
}

// Appends the pose of the frame to the path. Copies the whole path only after a correction of
// earlier poses.
void LiveRun::NotePath(const SlamRunFrame& frame) {
  const FrameReport& report = frame.report;
  if (!frame.backend) return path_.push_back({report.stamp_s, report.world_from_camera});
  const BackendCounts counts = frame.backend->counts();
  const std::array<std::size_t, 3> corrections = {counts.corrections, counts.loops_accepted,
                                                  frame.backend->calibrations().size()};
  const bool grows_by_one = path_.size() + 1 == frame.backend->poses().frames().size();
  if (grows_by_one && corrections == corrections_) {
    return path_.push_back({report.stamp_s, report.world_from_camera});
  }
  corrections_ = corrections;
  path_ = frame.backend->poses().trajectory();
  NoteLoops(*frame.backend);
}

void LiveRun::NoteLoops(const Backend& backend) {
  std::map<int, Eigen::Vector3d> positions;
  loops_.clear();
  for (const LoopRecord& loop : backend.poses().loops()) {
    if (!loop.in_graph) continue;
    if (positions.empty()) {
      for (const PosedFrame& frame : backend.poses().frames()) {
        positions[frame.index] = frame.world_from_camera.translation;
      }
    }
    loops_.push_back({positions.at(loop.source_frame), positions.at(loop.target_frame)});
    last_loop_ = {loop.source_frame, loop.target_frame};
  }
}

std::string LiveRun::Status() const {
  if (is_done_) return "done";
  if (progress_.frames_reintegrated > 0) {
    return Concat("re-integrating frames: ", progress_.frames_reintegrated, "/",
                  progress_.frames_done);
  }
  if (progress_.refinement_rounds > 0) {
    return Concat("refining poses and camera: round ", progress_.refinement_rounds);
  }
  std::string total;
  if (progress_.frames_total >= 0) total = "/" + std::to_string(progress_.frames_total);
  std::array<char, 160> text;
  std::snprintf(text.data(), text.size(), "frame %d%s   %s   %.1f fps   %.2f M surfels",
                progress_.frames_done, total.c_str(), ToString(state_).c_str(), frames_per_second(),
                static_cast<double>(progress_.map_points) * 1e-6);
  return text.data();
}

}  // namespace surfit
