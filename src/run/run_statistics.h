#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <vector>

#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Counts and times of the frames of a run, for the summary. elapsed_s() begins with construction.
// Order per frame: CountRead(), RecordPoseTime(), CountProcessed(), CompleteFrame(), AddTimes().
// Order per unreadable frame: CountRead(), CountSkipped(), CompleteFrame(). Not thread-safe.
class RunStatistics {
 public:
  // Keeps a reference to the options.
  explicit RunStatistics(const SlamOptions& options);

  // Starts the time of the first frame. Call once, before the first frame.
  void BeginFrames() { last_completion_ = Clock::now(); }
  // Counts a frame, also if it is unreadable. Excludes ReadResult::waited_ms.
  void CountRead(const ReadResult& result);
  void CountSkipped() { ++summary_.frames_skipped; }
  // Counts a frame that Slam has processed.
  void CountProcessed(const RgbdFrame& frame, const FrameReport& report);
  // Call when the pose of the current frame is known.
  void RecordPoseTime() { pose_known_ = Clock::now(); }
  // Completes the current frame. Returns its frame time, ms. It is the time since the previous
  // completion.
  double CompleteFrame();
  // `offered`: the frame did not wait for the program, so its latency is counted.
  void AddTimes(const ReadResult& result, const StageTimes& times, double write_ms, bool offered);
  // Time of an offered frame since its arrival, ms.
  double AgeMs(const ReadResult& result) const { return AgeMs(result, Clock::now()); }
  // Runs `call` and excludes its duration from the frame time.
  template <typename Call>
  void LeaveOut(const Call& call) {
    const Clock::time_point before = Clock::now();
    call();
    last_completion_ += Clock::now() - before;
  }

  // Number of frames so far, with dropped frames.
  int frames_done() const { return summary_.frames_total + summary_.frames_dropped; }
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  const std::vector<double>& stamps_s() const { return stamps_s_; }

  // Summary with counts and times only. Other fields have their defaults. Without frames, the
  // ratios of the stages are NaN.
  SlamRunSummary Summary(std::size_t map_points) const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::array<const char*, 7> kStages = {"read", "preprocess", "predict", "track",
                                                         "fuse", "correct",    "write"};

  void CountFused(const FrameReport& report, std::int64_t valid_points);
  double AgeMs(const ReadResult& result, Clock::time_point now) const;

  const SlamOptions& options_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_completion_ = start_, taken_ = start_, pose_known_ = start_;
  SlamRunSummary summary_;
  bool has_much_motion_ = false;  // the last tracked frame had more than 10 % moving points
  std::vector<double> stamps_s_, frame_ms_, latency_ms_, pose_latency_ms_, match_shares_;
  std::array<std::vector<double>, kStages.size()> stages_ms_;
};

}  // namespace surfit
