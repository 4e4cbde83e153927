#include "surfit/run/slam_run.h"

#include <glog/logging.h>
#include <sys/resource.h>

#include <memory>

#include "run/digest.h"
#include "run/kept_views.h"
#include "run/output_files.h"
#include "run/result_files.h"
#include "run/run_files.h"
#include "run/run_statistics.h"
#include "run/sequence_slam.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/core/trace.h"
#include "surfit/io/frame_source.h"
#include "surfit/io/point_cloud.h"
#include "surfit/io/sequence.h"
#include "surfit/pictures/pictures.h"

namespace surfit {
namespace {

using ProgressCall = std::function<void(const SlamRunProgress&)>;

// Frames that are still to come are read when asked for: waiting for them would hold a thread.
std::unique_ptr<FrameSource> OpenSource(const SlamRunOptions& options,
                                        const std::atomic<bool>& interrupted) {
  if (options.sequence.format == "watch") return WatchFolder(options.sequence, interrupted);
  auto source = OpenSequence(options.sequence);
  if (options.offered_fps == 0) return ReadAhead(std::move(source), options.queue_capacity);
  return OfferFrames(std::move(source), options.offered_fps, options.queue_capacity);
}

std::int64_t PeakRssBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

// The ground truth from the first to the last of these stamps, with what it takes to interpolate.
Trajectory TruthDuring(const std::vector<double>& stamps_s, const Trajectory& ground_truth) {
  const double kMarginSeconds = MatchOptions().max_gap_s;
  Trajectory truth;
  for (const StampedPose& pose : ground_truth) {
    if (pose.stamp_s >= stamps_s.front() - kMarginSeconds &&
        pose.stamp_s <= stamps_s.back() + kMarginSeconds) {
      truth.push_back(pose);
    }
  }
  return truth;
}

Trajectory AlignedWithTruth(Trajectory trajectory,
                            const std::optional<TrajectoryEvaluation>& evaluation) {
  if (!evaluation || !evaluation->ate) return trajectory;
  for (StampedPose& pose : trajectory) {
    pose.world_from_camera = evaluation->ate->alignment.target_from_source * pose.world_from_camera;
  }
  return trajectory;
}

// A run in progress: frames from the source go through SLAM, and what it makes of them to the
// statistics and files.
class SlamRun {
 public:
  SlamRun(const SlamRunOptions& options, const std::atomic<bool>& interrupted)
      : options_(options),
        statistics_(options.slam),
        source_(OpenSource(options, interrupted)),
        given_field_(ReadDepthField(options.sequence, source_->info().format)),
        slam_(options, source_->info()) {
    PrepareOutputFolder(options.output, RunFileNames());
    if (!options.trace.empty()) trace_ = std::make_unique<TraceRecorder>(options.trace);
    files_ = std::make_unique<RunFiles>(options.output, source_->info().mirrored);
  }

  SlamRunSummary Run(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    while (!interrupted || !slam_.HasBegun()) {  // an interrupted run has one frame at least
      const std::optional<ReadResult> result = source_->Next();
      if (!result) break;
      statistics_.CountRead(*result);
      if (result->frame) {
        const FrameReport report = Process(*result);
        const SlamRunFrame frame = {*result->frame, report, slam_.map(), slam_.slam().sensor()};
        Tell(&frame, progress);
      } else {
        Skip(*result);
        Tell(nullptr, progress);
      }
    }
    if (!slam_.HasBegun()) throw InputError(options_.sequence.path + ": no frame could be read");
    return Finish(interrupted);
  }

 private:
  // Whoever is told may take their time, and pause.
  void Tell(const SlamRunFrame* frame, const ProgressCall& progress) {
    statistics_.LeaveOut([&] {
      progress({statistics_.frames_done(), slam_.info().frame_count,
                slam_.HasBegun() ? slam_.map().size() : 0, statistics_.elapsed_s(), frame});
    });
  }

  void Skip(const ReadResult& result) {
    LOG(WARNING) << "frame " << result.index << " skipped: " << result.error;
    statistics_.CountSkipped();
    files_->WriteSkipped(result, statistics_.CompleteFrame());
  }

  FrameReport Process(const ReadResult& result) {
    const RgbdFrame& frame = *result.frame;
    const TraceSlice slice("frame", frame.index);
    FrameReport report = slam_.Process(frame);
    statistics_.CountProcessed(frame, report);
    if (options_.keep_views) views_.Offer(frame, report, slam_.map(), slam_.slam().sensor());
    double write_ms = 0;
    {
      const StageTimer timer("write", frame.index, &write_ms);
      files_->Write(report, result.decode_ms, statistics_.CompleteFrame());
    }
    statistics_.AddTimes(result, report.times, write_ms, options_.offered_fps > 0);
    return report;
  }

  SlamRunSummary Finish(bool interrupted) {
    slam_.Finish();
    SlamRunSummary summary = statistics_.Summary(slam_.map().size());
    summary.interrupted = interrupted;
    summary.sensor_latency_s = slam_.info().camera.latency_s;
    if (slam_.slam().backend()) FinishBackend(&summary);
    summary.digest = Digest(slam_.trajectory(), slam_.map());
    if (!slam_.info().ground_truth.empty()) Evaluate(&summary);
    WriteResults(summary);
    if (trace_) trace_->Close();
    summary.peak_rss_bytes = PeakRssBytes();
    summary.total_s = statistics_.elapsed_s();
    WriteSummaryJson(summary, options_, Path("summary.json"));
    return summary;
  }

  void Evaluate(SlamRunSummary* summary) const {
    const Trajectory& truth = slam_.info().ground_truth;
    const Trajectory& estimate = slam_.trajectory();
    summary->evaluation = EvaluateTrajectory(truth, estimate, statistics_.stamps_s(), {});
    const auto without = EvaluateTimeOffset(truth, estimate, summary->sensor_latency_s, {});
    if (without) summary->ate_without_latency = without->ate;
    summary->time_offset = EstimateTimeOffset(truth, estimate, {});
  }

  void FinishBackend(SlamRunSummary* summary) {
    const Slam& slam = slam_.slam();
    const Backend& backend = *slam.backend();
    files_->Rewrite(slam_.trajectory());
    summary->loops = backend.counts();
    summary->merged_doubles = static_cast<std::int64_t>(slam.merged_doubles());
    if (options_.slam.loops.enabled) WriteLoopsCsv(backend.loops(), Path("loops.csv"));
    summary->calibrations = backend.calibrations();
    if (!backend.is_recalibrated()) return;
    summary->calibration = *backend.calibration();
    WriteFoundCamera(slam_.info(), given_field_, *summary->calibration, Path("camera.yaml"));
  }

  // Map, views, poses and pictures.
  void WriteResults(const SlamRunSummary& summary) const {
    {
      const TraceSlice slice("write_map");
      WriteSurfelPly(slam_.map(), Path("map.ply"));
    }
    const DepthSensor sensor = slam_.slam().sensor();
    const std::vector<KeptView> views = views_.Finish(slam_.map(), sensor);
    KeptViews::Write(views, options_.output);
    const Trajectory truth = TruthDuring(statistics_.stamps_s(), slam_.info().ground_truth);
    WritePosesJson(
        {sensor.camera, slam_.trajectory(), slam_.frames(), truth, summary.evaluation, views},
        Path("poses.json"));
    if (!options_.pictures) return;
    const TraceSlice slice("write_pictures");
    WriteMapPictures(slam_.map(), slam_.trajectory(), options_.output);
    WriteTrajectoryPicture(AlignedWithTruth(slam_.trajectory(), summary.evaluation), truth,
                           Path("trajectory.png"));
  }

  std::string Path(const char* name) const { return options_.output + "/" + name; }

  const SlamRunOptions& options_;
  RunStatistics statistics_;
  std::unique_ptr<TraceRecorder> trace_;  // outlives the source, which decodes on another thread
  std::unique_ptr<FrameSource> source_;
  InverseDepthField given_field_;  // that frames come with
  SequenceSlam slam_;
  std::unique_ptr<RunFiles> files_;
  KeptViews views_;
};

}  // namespace

SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  SlamRunOptions run = options;
  // While a doubtful frame is looked for, the camera moves on: the next would be far, too.
  if (options.offered_fps > 0) run.slam.sure_inlier_share = 0;
  return SlamRun(run, interrupted).Run(interrupted, progress);
}

}  // namespace surfit
