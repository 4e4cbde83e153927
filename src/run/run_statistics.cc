#include "run/run_statistics.h"

#include <glog/logging.h>

#include <algorithm>
#include <numeric>

#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

constexpr double kMuchMotion = 0.1;

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.);
}

TimeStatistics Statistics(const std::vector<double>& times_ms) {
  const double count = std::max<double>(1, static_cast<double>(times_ms.size()));
  return {Sum(times_ms) / count, Quantile(times_ms, 0.5), Quantile(times_ms, 0.95)};
}

std::int64_t CountValid(const Image<float>& depth_m) {
  return std::count_if(depth_m.begin(), depth_m.end(), [](float depth) { return depth > 0; });
}

bool IsRegistered(FrameState state) {
  return state == FrameState::kTracked || state == FrameState::kDegenerate ||
         state == FrameState::kRelocalized;
}

}  // namespace

RunStatistics::RunStatistics(const SlamOptions& options) : options_(options) {}

void RunStatistics::CountRead(const ReadResult& result) {
  last_completion_ += std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double, std::milli>(result.waited_ms));
  taken_ = Clock::now();
  summary_.frames_dropped += result.dropped_before;
  summary_.pauses += result.paused_before_s > 0;
  summary_.paused_s += result.paused_before_s;
  ++summary_.frames_total;
  stamps_s_.push_back(result.stamp_s);
}

void RunStatistics::CountProcessed(const RgbdFrame& frame, const FrameReport& report) {
  const std::int64_t valid_points = CountValid(frame.depth_m);
  summary_.input_points += static_cast<std::int64_t>(frame.depth_m.size());
  summary_.input_points_valid += valid_points;
  summary_.frames_with_two_motions += report.has_two_motions;
  summary_.frames_confirmed += report.confirmed.has_value();
  if (!report.HasPose()) {
    ++summary_.frames_lost;
    summary_.frames_lost_in_motion += has_much_motion_;
    return;
  }
  ++summary_.frames_tracked;
  summary_.frames_degenerate += report.state == FrameState::kDegenerate;
  has_much_motion_ = report.moving_ratio > kMuchMotion;
  summary_.frames_with_motion += has_much_motion_;
  if (report.is_held_out) summary_.held_out_frames.push_back(report.index);
  if (IsRegistered(report.state) && options_.icp.error_model.UsesIntensities() &&
      report.icp.intensity_count == 0) {
    ++summary_.frames_without_intensities;
  }
  CountFused(report, valid_points);
}

void RunStatistics::CountFused(const FrameReport& report, std::int64_t valid_points) {
  summary_.updated += report.fusion.merged;
  summary_.added += report.fusion.added;
  summary_.removed += report.fusion.removed;
  if (summary_.refused == 0 && report.fusion.refused > 0) {
    LOG(WARNING) << "frame " << report.index
                 << ": the map is full, new surfaces are not mapped: max_map_points is "
                 << options_.fusion.max_map_points;
  }
  summary_.refused += report.fusion.refused;
  if (!report.is_fused) return;
  ++summary_.frames_fused;
  if (valid_points == 0) return;
  match_shares_.push_back(static_cast<double>(report.fusion.merged_points) /
                          static_cast<double>(valid_points));
}

double RunStatistics::CompleteFrame() {
  const Clock::time_point now = Clock::now();
  const double ms = std::chrono::duration<double, std::milli>(now - last_completion_).count();
  last_completion_ = now;
  frame_ms_.push_back(ms);
  return ms;
}

double RunStatistics::AgeMs(const ReadResult& result, Clock::time_point now) const {
  return result.queued_ms + std::chrono::duration<double, std::milli>(now - taken_).count();
}

void RunStatistics::AddTimes(const ReadResult& result, const StageTimes& times, double write_ms,
                             bool offered) {
  if (offered) {
    latency_ms_.push_back(AgeMs(result));
    pose_latency_ms_.push_back(AgeMs(result, pose_known_));
  }
  const std::array<double, kStages.size()> stages_ms = {
      result.read_ms, times.preprocess_ms, times.predict_ms, times.track_ms,
      times.fuse_ms,  times.correct_ms,    write_ms};
  for (std::size_t i = 0; i < kStages.size(); ++i) stages_ms_[i].push_back(stages_ms[i]);
}

SlamRunSummary RunStatistics::Summary(std::size_t map_points) const {
  SlamRunSummary summary = summary_;
  summary.map_points = map_points;
  if (map_points > 0) {
    summary.compression_ratio =
        static_cast<double>(summary.input_points) / static_cast<double>(map_points);
  }
  summary.match_ratio_last = match_shares_.empty() ? 0 : match_shares_.back();
  summary.match_ratio_median = Quantile(match_shares_, 0.5);
  summary.frame = Statistics(frame_ms_);
  summary.latency = Statistics(latency_ms_);
  summary.pose_latency = Statistics(pose_latency_ms_);
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    summary.stages.push_back(
        {kStages[i], Statistics(stages_ms_[i]), Sum(stages_ms_[i]) / Sum(frame_ms_)});
  }
  return summary;
}

}  // namespace surfit
