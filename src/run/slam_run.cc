#include "surfit/run/slam_run.h"

#include <glog/logging.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "run/digest.h"
#include "run/given_poses.h"
#include "run/kept_views.h"
#include "run/loop_files.h"
#include "run/output_folder.h"
#include "run/poses_json.h"
#include "run/run_files.h"
#include "run/summary_json.h"
#include "run/tracking_dump.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/core/trace.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/io/offered_frames.h"
#include "surfit/io/read_ahead.h"
#include "surfit/io/surfel_ply.h"
#include "surfit/io/watch_folder.h"
#include "surfit/pictures/pictures.h"

namespace surfit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<const char*, 7> kStages = {"decode", "preprocess", "predict", "track",
                                                "fuse",   "correct",    "write"};

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.);
}

TimeStatistics Statistics(const std::vector<double>& times_ms) {
  const double count = std::max<double>(1, static_cast<double>(times_ms.size()));
  return {Sum(times_ms) / count, Quantile(times_ms, 0.5), Quantile(times_ms, 0.95)};
}

std::int64_t PeakRssBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

std::int64_t CountValid(const Image<float>& depth_m) {
  return std::count_if(depth_m.begin(), depth_m.end(), [](float depth) { return depth > 0; });
}

// Frames that are still to come are read when asked for: waiting for them would hold a thread.
std::unique_ptr<FrameSource> OpenSource(const SlamRunOptions& options,
                                        const std::atomic<bool>& interrupted) {
  if (options.sequence.format == "watch") return WatchFolder(options.sequence, interrupted);
  auto source = OpenSequence(options.sequence);
  if (options.offered_fps == 0) return ReadAhead(std::move(source), options.queue_capacity);
  return OfferFrames(std::move(source), options.offered_fps, options.queue_capacity);
}

// A run in progress.
class SlamRun {
 public:
  SlamRun(const SlamRunOptions& options, const std::atomic<bool>& interrupted)
      : options_(options),
        start_(Clock::now()),
        last_completion_(start_),
        source_(OpenSource(options, interrupted)),
        info_(source_->info()) {
    if (options.poses == "groundtruth" && info_.ground_truth.empty()) {
      throw InputError(
          Concat("poses is 'groundtruth', but ", options.sequence.path, " has no ground truth"));
    }
    PrepareOutputFolder(options.output, RunFileNames());
    if (!options.trace.empty()) trace_ = std::make_unique<TraceRecorder>(options.trace);
    files_ = std::make_unique<RunFiles>(options.output, info_.mirrored);
  }

  SlamRunSummary Run(const std::atomic<bool>& interrupted,
                     const std::function<void(const SlamRunProgress&)>& progress) {
    while (!interrupted || !slam_) {  // an interrupted run has one frame at least
      const std::optional<ReadResult> result = source_->Next();
      if (!result) break;
      last_completion_ += std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double, std::milli>(result->waited_ms));
      summary_.frames_dropped += result->dropped_before;
      ++summary_.frames_total;
      stamps_s_.push_back(result->stamp_s);
      if (result->frame) {
        const FrameReport report = Process(*result);
        const SlamRunFrame frame = {*result->frame, report, slam_->map(), info_.pinhole};
        Tell(&frame, progress);
      } else {
        Skip(*result);
        Tell(nullptr, progress);
      }
    }
    summary_.interrupted = interrupted;
    if (!slam_) throw InputError(options_.sequence.path + ": no frame could be read");
    return Finish();
  }

 private:
  // Whoever is told may take their time, and pause: it must not count as the next frame's.
  void Tell(const SlamRunFrame* frame,
            const std::function<void(const SlamRunProgress&)>& progress) {
    const Clock::time_point before = Clock::now();
    progress({summary_.frames_total + summary_.frames_dropped, info_.frame_count,
              slam_ ? slam_->map().size() : 0, SecondsSince(start_), frame});
    last_completion_ += Clock::now() - before;
  }

  // Wall time since the last frame was completed.
  double CompleteFrame() {
    const Clock::time_point now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_completion_).count();
    last_completion_ = now;
    frame_ms_.push_back(ms);
    return ms;
  }

  void Skip(const ReadResult& result) {
    LOG(WARNING) << "frame " << result.index << " skipped: " << result.error;
    ++summary_.frames_skipped;
    files_->WriteSkipped(result, CompleteFrame());
  }

  FrameReport Process(const ReadResult& result) {
    const Clock::time_point taken = Clock::now();
    const RgbdFrame& frame = *result.frame;
    const TraceSlice slice("frame", frame.index);
    if (!slam_) {
      slam_ = std::make_unique<Slam>(info_.pinhole, options_.slam,
                                     InitialPose(options_.initial_pose, info_, frame.stamp_s));
      if (!options_.dump_failures.empty()) {
        slam_->OnLostFrame([this](const LostFrame& lost) { Dump(lost); });
      }
    }
    const FrameReport report = ProcessFrame(frame);
    const std::int64_t valid = CountValid(frame.depth_m);
    summary_.input_points += static_cast<std::int64_t>(frame.depth_m.size());
    summary_.input_points_valid += valid;
    Count(report, valid);
    if (options_.keep_views) views_.Offer(frame, report, slam_->map(), info_.pinhole);
    double write_ms = 0;
    {
      const StageTimer timer("write", frame.index, &write_ms);
      files_->Write(report, result.decode_ms, CompleteFrame());
    }
    if (options_.offered_fps > 0) {
      latency_ms_.push_back(result.queued_ms + 1e3 * SecondsSince(taken));
    }
    const StageTimes& times = report.times;
    const std::array<double, kStages.size()> stages_ms = {
        result.decode_ms, times.preprocess_ms, times.predict_ms, times.track_ms,
        times.fuse_ms,    times.correct_ms,    write_ms};
    for (std::size_t i = 0; i < kStages.size(); ++i) stages_ms_[i].push_back(stages_ms[i]);
    return report;
  }

  void Dump(const LostFrame& lost) const {
    std::array<char, 30> name;
    std::snprintf(name.data(), name.size(), "/frame-%06d", lost.index);
    WriteTrackingDump(lost, options_.slam, options_.dump_failures + name.data());
  }

  FrameReport ProcessFrame(const RgbdFrame& frame) {
    if (options_.poses == "track") return slam_->Process(frame);
    const std::optional<Rigid3d> pose = InterpolatePose(info_.ground_truth, frame.stamp_s);
    if (pose) return slam_->ProcessAt(frame, *pose);
    LOG(WARNING) << "frame " << frame.index << " has no true pose within reach: not fused";
    FrameReport report;
    report.index = frame.index;
    report.stamp_s = frame.stamp_s;
    return report;
  }

  void Count(const FrameReport& report, std::int64_t valid_points) {
    if (report.state == FrameState::kLost) {
      ++summary_.frames_lost;
      return;
    }
    ++summary_.frames_tracked;
    const bool registered = report.state == FrameState::kTracked ||
                            report.state == FrameState::kDegenerate ||
                            report.state == FrameState::kRelocalized;
    if (registered && options_.slam.icp.error_model.UsesIntensities() &&
        report.icp.intensity_count == 0) {
      ++summary_.frames_without_intensities;
    }
    trajectory_.push_back({report.stamp_s, report.world_from_camera});
    pose_frames_.push_back(report.index);
    summary_.updated += report.fusion.merged;
    summary_.added += report.fusion.added;
    summary_.removed += report.fusion.removed;
    if (summary_.refused == 0 && report.fusion.refused > 0) {
      LOG(WARNING) << "from frame " << report.index << " on the map is full: max_map_points is "
                   << options_.slam.fusion.max_map_points;
    }
    summary_.refused += report.fusion.refused;
    if (!report.is_fused) return;
    ++summary_.frames_fused;
    if (valid_points == 0) return;
    match_shares_.push_back(static_cast<double>(report.fusion.merged_points) /
                            static_cast<double>(valid_points));
  }

  // Takes in the last loops, and what all of them have corrected.
  void FinishLoops() {
    slam_->Finish();
    if (!slam_->backend()) return;
    trajectory_ = slam_->backend()->trajectory();
    files_->Rewrite(trajectory_);
    summary_.loops = slam_->backend()->counts();
    summary_.merged_doubles = static_cast<std::int64_t>(slam_->merged_doubles());
    WriteLoopsCsv(slam_->backend()->loops(), options_.output + "/loops.csv");
  }

  SlamRunSummary Finish() {
    FinishLoops();
    const SurfelMap& map = slam_->map();
    summary_.map_points = map.size();
    if (map.size() > 0) {
      summary_.compression_ratio =
          static_cast<double>(summary_.input_points) / static_cast<double>(map.size());
    }
    summary_.match_share_last = match_shares_.empty() ? 0 : match_shares_.back();
    summary_.match_share_median = Quantile(match_shares_, 0.5);
    summary_.frame = Statistics(frame_ms_);
    summary_.latency = Statistics(latency_ms_);
    for (std::size_t i = 0; i < kStages.size(); ++i) {
      summary_.stages.push_back(
          {kStages[i], Statistics(stages_ms_[i]), Sum(stages_ms_[i]) / Sum(frame_ms_)});
    }
    summary_.digest = Digest(trajectory_, map);
    if (!info_.ground_truth.empty()) {
      summary_.evaluation = EvaluateTrajectory(info_.ground_truth, trajectory_, stamps_s_, {});
    }
    {
      const TraceSlice slice("write_map");
      WriteSurfelPly(map, options_.output + "/map.ply");
    }
    const std::vector<KeptView> views = views_.Finish(map, info_.pinhole);
    KeptViews::Write(views, options_.output);
    WritePosesJson(
        {info_.pinhole, trajectory_, pose_frames_, TruthOfTheRun(), summary_.evaluation, views},
        options_.output + "/poses.json");
    if (options_.pictures) WritePictures();
    if (trace_) trace_->Close();
    summary_.peak_rss_bytes = PeakRssBytes();
    summary_.total_s = SecondsSince(start_);
    WriteSummaryJson(summary_, options_, options_.output + "/summary.json");
    return summary_;
  }

  void WritePictures() const {
    const TraceSlice slice("write_pictures");
    WriteMapPictures(slam_->map(), trajectory_, options_.output);
    Trajectory aligned = trajectory_;
    if (summary_.evaluation && summary_.evaluation->ate) {
      const Rigid3d& true_from_estimated = summary_.evaluation->ate->alignment.target_from_source;
      for (StampedPose& pose : aligned) {
        pose.world_from_camera = true_from_estimated * pose.world_from_camera;
      }
    }
    WriteTrajectoryPicture(aligned, TruthOfTheRun(), options_.output + "/trajectory.png");
  }

  // The ground truth from the first to the last frame of the run.
  Trajectory TruthOfTheRun() const {
    constexpr double kMarginSeconds = 0.02;
    Trajectory truth;
    for (const StampedPose& pose : info_.ground_truth) {
      if (pose.stamp_s >= stamps_s_.front() - kMarginSeconds &&
          pose.stamp_s <= stamps_s_.back() + kMarginSeconds) {
        truth.push_back(pose);
      }
    }
    return truth;
  }

  const SlamRunOptions& options_;
  const Clock::time_point start_;
  Clock::time_point last_completion_;
  std::unique_ptr<TraceRecorder> trace_;  // outlives the source, which decodes on another thread
  std::unique_ptr<FrameSource> source_;
  const SequenceInfo& info_;
  std::unique_ptr<RunFiles> files_;
  std::unique_ptr<Slam> slam_;
  SlamRunSummary summary_;
  Trajectory trajectory_;
  std::vector<int> pose_frames_;  // the trajectory's poses' frames
  KeptViews views_;
  std::vector<double> stamps_s_;
  std::vector<double> frame_ms_, latency_ms_;
  std::vector<double> match_shares_;
  std::array<std::vector<double>, kStages.size()> stages_ms_;
};

}  // namespace

SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  return SlamRun(options, interrupted).Run(interrupted, progress);
}

}  // namespace surfit
