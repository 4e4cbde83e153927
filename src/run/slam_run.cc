#include "surfit/run/slam_run.h"

#include <sys/resource.h>

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/repeated_warning.h"
#include "core/trace.h"
#include "finishing/final_map.h"
#include "finishing/final_refinement.h"
#include "finishing/found_sensor.h"
#include "io/files/output_folder.h"
#include "io/files/places_file.h"
#include "output/output_files.h"
#include "run/kept_session.h"
#include "run/map_period.h"
#include "run/results/digest.h"
#include "run/results/failures.h"
#include "run/results/kept_views.h"
#include "run/results/localization.h"
#include "run/results/result_files.h"
#include "run/results/run_files.h"
#include "run/run_results.h"
#include "run/run_statistics.h"
#include "run/sequence_slam.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

using ProgressCall = std::function<void(const SlamRunProgress&)>;

// Frames that are still to come are read when asked for: waiting for them would hold a thread.
std::unique_ptr<FrameSource> OpenSource(const SlamRunOptions& options,
                                        const std::atomic<bool>& interrupted) {
  if (IsLive(options.sequence)) {
    return OpenLive(options.sequence, options.queue_capacity, interrupted);
  }
  auto source = OpenSequence(options.sequence);
  if (options.offered_fps == 0) return ReadAhead(std::move(source), options.queue_capacity);
  return OfferFrames(std::move(source), options.offered_fps, options.queue_capacity);
}

std::int64_t PeakRssBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

// A run in progress: frames from the source go through SLAM, and what it makes of them to the
// statistics and files.
class SlamRun {
 public:
  // The session is null without one.
  SlamRun(const SlamRunOptions& options, KeptSession* session, const std::atomic<bool>& interrupted)
      : options_(options),
        session_(session),
        statistics_(options.slam),
        map_period_(options.slam.map_period),
        source_(OpenSource(options, interrupted)),
        info_(source_->info()),
        given_field_(ReadDepthField(options.sequence, info_.format)),
        slam_(options, info_, session, [this](const FrameReport&) { statistics_.PoseIsKnown(); }),
        folder_(options.output, RunFileNames(), {options.sequence.camera}) {
    if (!options.trace.empty()) trace_ = std::make_unique<TraceRecorder>(options.trace);
    files_ = std::make_unique<RunFiles>(options.output, info_.mirrored);
    if (options.localize) {
      localization_ = std::make_unique<LocalizationFile>(Path("localization.csv"), info_.mirrored);
    }
  }

  // What ends the run early does not take with it what there is.
  SlamRunSummary Run(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    failures_.Try([&] { ProcessFrames(interrupted, progress); });
    if (!slam_.HasBegun()) {
      throw InputError(failures_.any() ? failures_.text()
                                       : options_.sequence.path + ": no frame could be read");
    }
    SlamRunSummary summary = Finish(interrupted, progress);
    if (failures_.any()) throw InputError(failures_.text());
    return summary;
  }

  SlamRunResult result() const { return {map(), slam_.trajectory()}; }

 private:
  void ProcessFrames(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    statistics_.BeginFrames();
    while (!interrupted || !slam_.HasBegun()) {  // an interrupted run has one frame at least
      std::optional<ReadResult> result = source_->Next();
      if (!result) break;
      if (session_) session_->Shift(&*result);
      statistics_.CountRead(*result);
      if (result->frame) {
        const FrameReport report = Process(*result);
        const SlamRunFrame frame = {*result->frame,
                                    report,
                                    slam_.map(),
                                    slam_.slam().sensor(),
                                    slam_.slam().backend(),
                                    options_.OffersFrames() ? statistics_.AgeMs(*result) : 0};
        Tell(&frame, progress);
      } else {
        Skip(*result);
        Tell(nullptr, progress);
      }
    }
  }

  // Whoever is told may take their time, and pause.
  void Tell(const SlamRunFrame* frame, const ProgressCall& progress) {
    statistics_.LeaveOut([&] {
      SlamRunProgress now = Progress();
      now.frame = frame;
      progress(now);
    });
  }

  void Skip(const ReadResult& result) {
    skipped_.Tell(Concat("frame ", result.index, " skipped: ", result.error));
    statistics_.CountSkipped();
    files_->WriteSkipped(result, statistics_.CompleteFrame());
  }

  FrameReport Process(const ReadResult& result) {
    const RgbdFrame& frame = *result.frame;
    const TraceSlice slice("frame", frame.index);
    is_whole_ = false;
    if (options_.OffersFrames()) slam_.SetMapPeriod(map_period_.For(result.queued_ms));
    FrameReport report = slam_.Process(frame);
    is_whole_ = true;
    statistics_.CountProcessed(frame, report);
    if (localization_) localization_->Add(report);
    if (report.is_held_out || report.state == FrameState::kFrozen) left_out_.insert(report.index);
    if (!report.moving.empty()) moving_[report.index] = report.moving;
    if (options_.keep_views) {
      views_.Offer(frame, report, slam_.map(), slam_.slam().sensor());
      thumbnails_.Offer(frame);
    }
    double write_ms = 0;
    {
      const StageTimer timer("write", frame.index, &write_ms);
      files_->Write(report, result.decode_ms, statistics_.CompleteFrame());
    }
    statistics_.AddTimes(result, report.times, write_ms, options_.OffersFrames());
    return report;
  }

  SlamRunSummary Finish(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    source_.reset();  // of a long recording its list of frames is large
    if (!is_whole_ || !failures_.Try([&] { slam_.Finish(); })) {
      failures_.Try([&] { slam_.FinishEarly(); });
    }
    failures_.Try([&] { Improve(interrupted, progress); });
    SlamRunSummary summary;
    failures_.Try([&] { summary = statistics_.Summary(map().size()); });
    if (final_map_) summary.refinement = refinement_;
    summary.final_map_s = final_map_s_;
    summary.interrupted = interrupted;
    summary.frames_hurried = map_period_.frames_hurried();
    summary.longest_map_period = map_period_.longest();
    summary.sensor_latency_s = slam_.info().camera.latency_s;
    if (slam_.slam().backend() || summary.refinement) {
      failures_.Try([&] { files_->Rewrite(slam_.trajectory()); });
    }
    if (slam_.slam().backend()) FinishBackend(&summary);
    if (session_) summary.session_waits = session_->waits();
    if (localization_) summary.localization = localization_->Summary();
    failures_.Try([&] { summary.digest = Digest(slam_.trajectory(), slam_.map()); });
    if (!slam_.info().ground_truth.empty()) failures_.Try([&] { Evaluate(&summary); });
    WriteRunResults(
        {slam_, map(), views_, thumbnails_, statistics_.stamps_s(), summary.evaluation, options_},
        &failures_);
    if (trace_) failures_.Try([&] { trace_->Close(); });
    summary.peak_rss_bytes = PeakRssBytes();
    summary.total_s = statistics_.elapsed_s();
    summary.failure = failures_.text();
    failures_.Try([&] { WriteSummaryJson(summary, options_, Path("summary.json")); });
    return summary;
  }

  // Not of a run that has ended early, nor of frames that are gone.
  void Improve(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    if (!options_.final_map || IsLive(options_.sequence) || !is_whole_ || interrupted ||
        failures_.any() || options_.continue_session || options_.localize) {
      return;
    }
    std::optional<RefinedSequence> refined;
    const KnownSequence known = Known(slam_.trajectory(), slam_.found());
    // Where the camera is as given, tracking has seen more than keyframes tell.
    if (options_.refine && known.found.calibration) refined = Refine(known, interrupted, progress);
    if (interrupted) return;
    FuseFinalMap(refined ? Known(refined->trajectory, refined->found) : known, interrupted,
                 progress);
    if (!final_map_ || !refined) return;
    const bool is_better = refined->summary.Succeeded();
    slam_.Improve(std::move(*refined));
    if (session_ && is_better) {
      session_->Improve(slam_.trajectory(), slam_.frames(), slam_.found(), *final_map_);
    }
  }

  std::optional<RefinedSequence> Refine(const KnownSequence& known,
                                        const std::atomic<bool>& interrupted,
                                        const ProgressCall& progress) {
    const auto start = std::chrono::steady_clock::now();
    SlamRunProgress now = Progress();
    std::optional<RefinedSequence> refined =
        RefineKnown(known, slam_.info().pinhole, interrupted, [&](const RefinementRound&) {
          ++now.refinement_rounds;
          now.elapsed_s = statistics_.elapsed_s();
          progress(now);
        });
    if (!refined) return refined;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    const int last = slam_.frames().back();
    refinement_ = {{refined->keyframes, last, last, refined->summary, {}}, elapsed.count()};
    return refined;
  }

  void FuseFinalMap(const KnownSequence& known, const std::atomic<bool>& interrupted,
                    const ProgressCall& progress) {
    const TraceSlice slice("final_map");
    const auto start = std::chrono::steady_clock::now();
    SlamRunProgress now = Progress();
    final_map_ = FuseAnew(known, interrupted, [&](int frames, std::size_t points) {
      now.frames_fused_anew = frames;
      now.map_points = points;
      now.elapsed_s = statistics_.elapsed_s();
      progress(now);
    });
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (final_map_) final_map_s_ = elapsed.count();
  }

  KnownSequence Known(const Trajectory& trajectory, const FoundSensor& found) const {
    return {options_.sequence, options_.slam, trajectory, slam_.frames(),
            left_out_,         moving_,       found};
  }

  SlamRunProgress Progress() const {
    SlamRunProgress now;
    now.frames_done = statistics_.frames_done();
    now.frames_total = slam_.info().frame_count;
    now.map_points = slam_.HasBegun() ? slam_.map().size() : 0;
    now.elapsed_s = statistics_.elapsed_s();
    return now;
  }

  const SurfelMap& map() const { return final_map_ ? *final_map_ : slam_.map(); }

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
    failures_.Try([&] { files_->Rewrite(slam_.trajectory()); });
    summary->loops = backend.counts();
    summary->merged_doubles = static_cast<std::int64_t>(slam.merged_doubles());
    if (options_.slam.loops.enabled) {
      failures_.Try([&] { WriteLoopsCsv(backend.poses().loops(), Path("loops.csv")); });
    }
    if (options_.keep_places) {
      failures_.Try([&] {
        WritePlaces({backend.poses().frames(), backend.keyframe_views(), backend.poses().edges()},
                    Path("places.bin"));
      });
    }
    summary->calibrations = backend.calibrations();
    const DepthSensor given = slam_.info().sensor();
    summary->calibration = slam_.found().calibration;
    if (summary->calibration)
      summary->calibration_doubt = DoubtOfGiven(given, *summary->calibration);
    summary->color_latency_s = slam_.found().color_latency_s;
    if (!summary->calibration && summary->color_latency_s == 0) return;
    failures_.Try([&] {
      SequenceInfo info = slam_.info();
      info.camera.color_latency_s += summary->color_latency_s;
      const DepthCalibration as_given = {given.camera, {}, given.readout_s};
      WriteFoundCamera(info, given_field_, summary->calibration.value_or(as_given),
                       Path("camera.yaml"));
    });
  }

  std::string Path(const char* name) const { return options_.output + "/" + name; }

  const SlamRunOptions& options_;
  KeptSession* const session_;
  RunStatistics statistics_;
  MapPeriod map_period_;
  std::unique_ptr<TraceRecorder> trace_;  // outlives the source, which decodes on another thread
  std::unique_ptr<FrameSource> source_;   // closed once its frames have been processed
  const SequenceInfo info_;
  InverseDepthField given_field_;  // that frames come with
  SequenceSlam slam_;
  OutputFolder folder_;
  std::unique_ptr<RunFiles> files_;
  std::unique_ptr<LocalizationFile> localization_;  // null unless the camera is localised
  KeptViews views_;
  Thumbnails thumbnails_;
  RepeatedWarning skipped_{"frames skipped"};
  Failures failures_;
  std::set<int> left_out_;                     // frames that are not to be in the map
  std::map<int, Image<std::uint8_t>> moving_;  // FrameReport::moving, by frame
  std::optional<FinalRefinement> refinement_;
  std::optional<SurfelMap> final_map_;
  std::optional<double> final_map_s_;
  bool is_whole_ = true;  // no frame has ended within its processing
};

}  // namespace

SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress,
                       const std::function<void(const SlamRunResult&)>& finished) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  SlamRunOptions run = options;
  // While a doubtful frame is looked for, the camera moves on: the next would be far, too.
  if (options.OffersFrames()) {
    run.slam.sure_inlier_share = 0;
    run.slam.real_time = true;
  }
  std::unique_ptr<KeptSession> session;
  if (!run.session.empty()) session = std::make_unique<KeptSession>(&run);
  SlamRun slam(run, session.get(), interrupted);
  SlamRunSummary summary = slam.Run(interrupted, progress);
  if (finished) finished(slam.result());
  return summary;
}

}  // namespace surfit
