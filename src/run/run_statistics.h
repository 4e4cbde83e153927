#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <vector>

#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Counts and times of a run's frames, for its summary. Its life is the run's time.
class RunStatistics {
 public:
  explicit RunStatistics(const SlamOptions& options);

  // From here on time is the first frame's: to open a sequence is no frame's.
  void BeginFrames() { last_completion_ = Clock::now(); }
  // A frame has come, or could not be read. The time that was waited for it is no frame's.
  void CountRead(const ReadResult& result);
  void CountSkipped() { ++summary_.frames_skipped; }
  void CountProcessed(const RgbdFrame& frame, const FrameReport& report);
  // Of the frame at work.
  void PoseIsKnown() { pose_known_ = Clock::now(); }
  // The time from the last frame's completion to now, ms: this frame's.
  double CompleteFrame();
  // How long each stage of a processed frame took. An offered frame was taken from the queue by
  // CountRead().
  void AddTimes(const ReadResult& result, const StageTimes& times, double write_ms, bool offered);
  // Of an offered frame that was taken by CountRead(): since it was offered.
  double AgeMs(const ReadResult& result) const { return AgeMs(result, Clock::now()); }
  // What `call` takes is no frame's time.
  template <typename Call>
  void LeaveOut(const Call& call) {
    const Clock::time_point before = Clock::now();
    call();
    last_completion_ += Clock::now() - before;
  }

  int frames_done() const { return summary_.frames_total + summary_.frames_dropped; }
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  // Of all frames, those that could not be read included.
  const std::vector<double>& stamps_s() const { return stamps_s_; }

  // All counts and times of frames; the summary's other fields are not set.
  SlamRunSummary Summary(std::size_t map_points) const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::array<const char*, 7> kStages = {"decode", "preprocess", "predict", "track",
                                                         "fuse",   "correct",    "write"};

  void CountFused(const FrameReport& report, std::int64_t valid_points);
  double AgeMs(const ReadResult& result, Clock::time_point now) const;

  const SlamOptions& options_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_completion_ = start_, taken_ = start_, pose_known_ = start_;
  SlamRunSummary summary_;
  bool much_moves_ = false;  // in the last tracked frame
  std::vector<double> stamps_s_, frame_ms_, latency_ms_, pose_latency_ms_, match_shares_;
  std::array<std::vector<double>, kStages.size()> stages_ms_;
};

}  // namespace surfit
