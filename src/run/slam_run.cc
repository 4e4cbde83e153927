#include "surfit/run/slam_run.h"

#include <glog/logging.h>
#include <sys/resource.h>

#include <chrono>
#include <memory>
#include <utility>

#include "core/repeated_warning.h"
#include "core/trace.h"
#include "finishing/final_map.h"
#include "finishing/final_refinement.h"
#include "finishing/posed_sequence.h"
#include "io/files/output_folder.h"
#include "io/files/places_file.h"
#include "output/output_files.h"
#include "run/frame_facts.h"
#include "run/given_poses.h"
#include "run/map_period.h"
#include "run/measured_source.h"
#include "run/posed_views.h"
#include "run/results/evaluate_run.h"
#include "run/results/failures.h"
#include "run/results/kept_views.h"
#include "run/results/localization.h"
#include "run/results/result_files.h"
#include "run/results/run_files.h"
#include "run/run_results.h"
#include "run/run_session.h"
#include "run/run_statistics.h"
#include "run/start_slam.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_source.h"

namespace surfit {
namespace {

using ProgressCall = std::function<void(const SlamRunProgress&)>;

std::int64_t PeakRssBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

// Run of SLAM over one sequence. The stages of a frame are:
//   read                                                    FrameSource
//   correct, preprocess, predict, track, keyframe, fuse     Slam::Process()
//   write (pose, row of frames.csv)                         RunTrajectory, FrameTable
// After the last frame, poses and calibration are refined, the final map is fused, and all results
// are written (finishing, run_results.h).
class SlamRun {
 public:
  // `session` may be null. Options and session must outlive this object.
  SlamRun(const SlamRunOptions& options, RunSession* session, const std::atomic<bool>& interrupted)
      : options_(options),
        session_(session),
        statistics_(options.slam),
        map_period_(options.slam.map_period),
        source_(std::make_unique<MeasuredSource>(OpenSource(options, interrupted))),
        info_(WithGroundTruth(source_->info(), options)),
        given_field_(ReadDepthField(options.sequence, info_.format)),
        given_poses_(info_.pinhole),
        folder_(options.output, RunFileNames(), {options.sequence.camera}) {
    if (!options.trace.empty()) trace_ = std::make_unique<TraceRecorder>(options.trace);
    noise_ = source_->Measure(options_);
    info_.camera.noise.inverse_depth_sigma = noise_.used;
    // The sequence is opened again after the last frame.
    if (noise_.is_applied) options_.sequence.inverse_depth_sigma = noise_.used;
    trajectory_ = std::make_unique<RunTrajectory>(options.output, info_.mirrored);
    frame_table_ = std::make_unique<FrameTable>(options.output);
    if (options.localize) {
      localization_ = std::make_unique<LocalizationFile>(Path("localization.csv"), info_.mirrored);
    }
  }

  // Processes all frames and writes the results.
  SlamRunSummary Run(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    failures_.Try([&] { ProcessFrames(interrupted, progress); });
    if (!slam_) {
      throw InputError(failures_.any() ? failures_.text()
                                       : options_.sequence.path + ": no frame could be read");
    }
    SlamRunSummary summary = Finish(interrupted, progress);
    if (failures_.any()) throw InputError(failures_.text());
    return summary;
  }

  SlamRunResult result() const { return {map(), trajectory_->poses()}; }

 private:
  void ProcessFrames(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    statistics_.BeginFrames();
    while (!interrupted || !slam_) {  // at least one frame, even if interrupted
      std::optional<ReadResult> result = source_->Next();
      if (!result) break;
      if (session_) session_->Shift(&*result);
      statistics_.CountRead(*result);
      if (result->frame) {
        FrameReport report = Process(*result);
        const SlamRunFrame frame = {
            *result->frame,   report,
            slam_->map(),     slam_->sensor(),
            slam_->backend(), options_.OffersFrames() ? statistics_.AgeMs(*result) : 0};
        Tell(&frame, progress);
      } else {
        Skip(*result);
        Tell(nullptr, progress);
      }
    }
  }

  // Excluded from the run time: the callback can block, for example to pause the run.
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
    frame_table_->AddSkipped(result, statistics_.CompleteFrame());
  }

  FrameReport Process(const ReadResult& result) {
    const RgbdFrame& frame = *result.frame;
    const TraceSlice slice("frame", frame.index);
    is_frame_complete_ = false;
    FrameReport report = Track(result);
    is_frame_complete_ = true;
    Keep(frame, report);
    double write_ms = 0;
    {
      const StageTimer timer("write", frame.index, &write_ms);
      trajectory_->Add(report);
      frame_table_->Add(report, result.read_ms, statistics_.CompleteFrame());
    }
    statistics_.AddTimes(result, report.times, write_ms, options_.OffersFrames());
    return report;
  }

  FrameReport Track(const ReadResult& result) {
    const RgbdFrame& frame = *result.frame;
    if (options_.OffersFrames()) {
      const int period = map_period_.For(result.queued_ms);
      if (slam_) slam_->SetMapPeriod(period);
    }
    if (!slam_) {
      WeighColor(info_, noise_, !frame.color.empty(), &options_.slam);
      KeepCalibrationOfPhones(info_, &options_.slam);
      slam_ = StartSlam(options_, info_, session_, frame.stamp_s);
      slam_->OnPose([this](const FrameReport&) { statistics_.RecordPoseTime(); });
    }
    FrameReport report = options_.poses == "track" ? slam_->Process(frame) : FuseAtTruth(frame);
    if (session_) session_->SaveIfDue(*slam_, report.stamp_s);
    return report;
  }

  FrameReport FuseAtTruth(const RgbdFrame& frame) {
    const std::optional<Rigid3d> pose = InterpolatePose(info_.ground_truth, frame.stamp_s);
    if (pose) {
      given_poses_.Add(frame, *pose);
      return slam_->ProcessAt(frame, *pose);
    }
    without_truth_.Tell(
        Concat("frame ", frame.index, " has no ground-truth pose at its time and is not fused"));
    FrameReport report;
    report.index = frame.index;
    report.stamp_s = frame.stamp_s;
    return report;
  }

  void Keep(const RgbdFrame& frame, const FrameReport& report) {
    statistics_.CountProcessed(frame, report);
    facts_.Add(frame, report);
    if (localization_) localization_->Add(report);
    if (!options_.keep_views) return;
    views_.Offer(frame, report, slam_->map(), slam_->sensor());
    thumbnails_.Offer(frame);
  }

  SlamRunSummary Finish(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    if (const auto warning = given_poses_.Warning()) LOG(WARNING) << *warning;
    if (slam_->map().size() == 0) {
      if (const auto warning = facts_.DepthWarning(options_.slam.icp.min_inliers)) {
        LOG(WARNING) << *warning;
      }
    }
    source_.reset();  // frees the frame list, which is large for long recordings
    // The pose store may contain a failed frame, which Replace() drops.
    if (!is_frame_complete_ || !failures_.Try([&] { FinishSlam(); })) {
      failures_.Try([&] { TakeCorrections(); });
    }
    failures_.Try([&] { Improve(interrupted, progress); });
    failures_.Try([&] { FindLostPoses(interrupted); });
    SlamRunSummary summary;
    failures_.Try([&] { summary = statistics_.Summary(map().size()); });
    summary.noise = noise_;
    if (final_map_) summary.refinement = refinement_;
    summary.final_map_s = final_map_s_;
    summary.interrupted = interrupted;
    summary.frames_with_longer_map_period = map_period_.frames_with_longer_map_period();
    summary.longest_map_period = map_period_.longest();
    if (ImuReport imu = slam_->imu_report(); !imu.read_from.empty()) summary.imu = std::move(imu);
    summary.sensor_latency_s = info_.camera.latency_s;
    failures_.Try([&] { trajectory_->Finish(); });
    if (slam_->backend()) FinishBackend(&summary);
    WriteCamera(summary);
    summary.prior_poses = slam_->prior_poses();
    if (summary.prior_poses) WarnOfPriorPoses(options_.prior_poses, *summary.prior_poses);
    Trajectory largest_piece;
    failures_.Try([&] { largest_piece = FindPieces(&summary); });
    if (session_) summary.session_waits = session_->waits();
    if (localization_) summary.localization = localization_->Summary();
    failures_.Try([&] { summary.digest = Digest(trajectory_->poses(), slam_->map()); });
    if (!info_.ground_truth.empty()) {
      failures_.Try([&] {
        EvaluateRun(largest_piece, info_.ground_truth, statistics_.stamps_s(), options_, &summary);
      });
    }
    std::optional<UprightWorld> upright;
    failures_.Try([&] { upright = FindGravity(largest_piece, &summary); });
    if (options_.world == "run") upright.reset();
    WriteRunResults({info_, *trajectory_, largest_piece, found_, slam_->backend(), map(), views_,
                     thumbnails_, statistics_.stamps_s(), summary.evaluation, upright, options_},
                    &failures_);
    if (trace_) failures_.Try([&] { trace_->Close(); });
    summary.peak_rss_bytes = PeakRssBytes();
    summary.total_s = statistics_.elapsed_s();
    summary.failure = failures_.text();
    failures_.Try([&] { WriteSummaryJson(summary, options_, Path("summary.json")); });
    return summary;
  }

  void FinishSlam() {
    slam_->Finish();
    TakeCorrections();
    if (session_ && slam_->backend()) session_->Finish(*slam_);
  }

  // Takes the corrected poses and the estimated calibration. Localisation does not correct poses.
  void TakeCorrections() {
    const Backend* const backend = slam_->backend();
    if (!backend) return;
    if (!options_.localize) {
      const int first = session_ ? session_->first_index() : 0;
      Trajectory corrected;
      for (const PosedFrame& frame : backend->poses().frames()) {
        if (frame.index >= first) corrected.push_back({frame.stamp_s, frame.world_from_camera});
      }
      trajectory_->Replace(std::move(corrected));
    }
    if (backend->is_recalibrated()) found_.calibration = *backend->calibration();
    found_.color_latency_s = backend->color_latency_s();
  }

  // Returns true if the sequence can be read again, after a complete run from the first frame.
  bool CanReadAgain(const std::atomic<bool>& interrupted) const {
    return !IsLive(options_.sequence) && is_frame_complete_ && !interrupted && !failures_.any() &&
           !options_.continue_session && !options_.localize;
  }

  // Finds poses of lost frames between two frames of the same piece: by registration, else by the
  // inertial sensor.
  void FindLostPoses(const std::atomic<bool>& interrupted) {
    if (options_.poses != "track" || options_.localize) return;
    std::vector<PoseBetween> found;
    if (CanReadAgain(interrupted)) {
      found = FindPosesBetween(
          Known(trajectory_->poses(), found_),
          GapsOf(*trajectory_, slam_->backend() ? &slam_->backend()->poses() : nullptr,
                 facts_.lost()),
          interrupted);
    }
    AddBridgedFrames(slam_->bridged_frames(), *trajectory_, &found);
    trajectory_->Insert(found);
    std::vector<int> frames;
    frames.reserve(found.size());
    for (const PoseBetween& pose : found) frames.push_back(pose.frame);
    frame_table_->MarkFound(frames);
  }

  // Refines the run and fuses the final map. Does nothing for live sources, continued sessions,
  // localisation, and after an early end.
  void Improve(const std::atomic<bool>& interrupted, const ProgressCall& progress) {
    if (!options_.final_map || !CanReadAgain(interrupted)) return;
    std::optional<RefinedSequence> refined;
    const PosedSequence known = Known(trajectory_->poses(), found_);
    // Without a new calibration, RefinePosedSequence() changes nothing.
    if (options_.refine && known.found.calibration) refined = Refine(known, interrupted, progress);
    if (interrupted) return;
    FuseFinalMap(refined ? Known(refined->trajectory, refined->found) : known, interrupted,
                 progress);
    if (!final_map_ || !refined) return;
    found_ = refined->found;
    if (session_ && refined->is_applied) {
      session_->Improve(*slam_, trajectory_->poses(), trajectory_->frames(), found_, *final_map_);
    }
  }

  std::optional<RefinedSequence> Refine(const PosedSequence& known,
                                        const std::atomic<bool>& interrupted,
                                        const ProgressCall& progress) {
    const auto start = std::chrono::steady_clock::now();
    SlamRunProgress now = Progress();
    std::optional<RefinedSequence> refined =
        RefinePosedSequence(known, info_.pinhole, interrupted, [&](const RefinementRound&) {
          ++now.refinement_rounds;
          now.elapsed_s = statistics_.elapsed_s();
          progress(now);
        });
    if (!refined) return refined;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    const int last = trajectory_->frames().back();
    refinement_ = {{refined->keyframes, last, last, refined->summary, {}},
                   refined->held_out_gain,
                   refined->is_applied,
                   elapsed.count()};
    return refined;
  }

  void FuseFinalMap(const PosedSequence& known, const std::atomic<bool>& interrupted,
                    const ProgressCall& progress) {
    const TraceSlice slice("final_map");
    const auto start = std::chrono::steady_clock::now();
    SlamRunProgress now = Progress();
    std::optional<FinalMap> fused =
        IntegrateFinalMap(known, {options_.refine && options_.poses == "track", options_.stereo},
                          interrupted, [&](int frames, std::size_t points) {
                            now.frames_reintegrated = frames;
                            now.map_points = points;
                            now.elapsed_s = statistics_.elapsed_s();
                            progress(now);
                          });
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (!fused) return;
    final_map_ = std::move(fused->map);
    final_map_s_ = elapsed.count();
    trajectory_->Replace(std::move(fused->trajectory));
  }

  PosedSequence Known(const Trajectory& trajectory, const EstimatedSensor& found) const {
    return {options_.sequence, options_.slam,   trajectory, trajectory_->frames(),
            facts_.left_out(), facts_.moving(), found};
  }

  SlamRunProgress Progress() const {
    SlamRunProgress now;
    now.frames_done = statistics_.frames_done();
    now.frames_total = info_.frame_count;
    now.map_points = slam_ ? slam_->map().size() : 0;
    now.elapsed_s = statistics_.elapsed_s();
    return now;
  }

  const SurfelMap& map() const { return final_map_ ? *final_map_ : slam_->map(); }

  // Returns the poses of the largest piece.
  Trajectory FindPieces(SlamRunSummary* summary) const {
    const bool has_pieces = slam_->backend() && !options_.localize;
    TrajectoryPieces pieces =
        SplitIntoPieces(*trajectory_, has_pieces ? &slam_->backend()->poses() : nullptr,
                        info_.ground_truth, statistics_.stamps_s());
    summary->frames_with_pose = static_cast<int>(trajectory_->frames().size());
    summary->pieces = std::move(pieces.all);
    return std::move(pieces.largest);
  }

  std::optional<UprightWorld> FindGravity(const Trajectory& cameras,
                                          SlamRunSummary* summary) const {
    const UprightResult found = FindUpright(ReliableSurfels(map()), cameras);
    summary->gravity_unknown = found.reason;
    if (found.world) summary->gravity = {found.world->upright_from_world, found.world->sigma_rad};
    return found.world;
  }

  void FinishBackend(SlamRunSummary* summary) {
    const Slam& slam = *slam_;
    const Backend& backend = *slam.backend();
    summary->loops = backend.counts();
    summary->merged_duplicates = static_cast<std::int64_t>(slam.merged_duplicates());
    if (options_.slam.loops.enabled || !backend.poses().loops().empty()) {
      failures_.Try([&] { WriteLoopsCsv(backend.poses().loops(), Path("loops.csv")); });
    }
    if (options_.keep_places) {
      failures_.Try([&] {
        WritePlaces({backend.poses().frames(), backend.keyframe_views(), backend.poses().edges()},
                    Path("places.bin"));
      });
    }
    summary->calibrations = backend.calibrations();
    summary->calibration = found_.calibration;
    if (summary->calibration)
      summary->calibration_warning = CalibrationWarning(info_.sensor(), *summary->calibration);
    summary->color_latency_s = found_.color_latency_s;
  }

  // Writes camera.yaml if the run has estimated a value of it.
  void WriteCamera(const SlamRunSummary& summary) {
    if (!summary.calibration && summary.color_latency_s == 0 && !noise_.is_applied) return;
    failures_.Try([&] {
      SequenceInfo info = info_;
      info.camera.color_latency_s += summary.color_latency_s;
      const DepthCalibration as_given = {info_.pinhole, {}, info_.camera.readout_s};
      WriteEstimatedCamera(info, given_field_, summary.calibration.value_or(as_given),
                           Path("camera.yaml"));
    });
  }

  std::string Path(const char* name) const { return options_.output + "/" + name; }

  SlamRunOptions options_;
  RunSession* const session_;
  RunStatistics statistics_;
  MapPeriod map_period_;
  std::unique_ptr<TraceRecorder> trace_;    // outlives the source, which uses it on another thread
  std::unique_ptr<MeasuredSource> source_;  // closed after its last frame
  NoiseReport noise_;
  SequenceInfo info_;
  InverseDepthField given_field_;  // depth correction that is already applied to the frames
  GivenPoseCheck given_poses_;     // without frames if poses are tracked
  OutputFolder folder_;
  std::unique_ptr<RunTrajectory> trajectory_;
  std::unique_ptr<FrameTable> frame_table_;
  std::unique_ptr<Slam> slam_;
  EstimatedSensor found_;
  std::unique_ptr<LocalizationFile> localization_;  // null without localisation
  KeptViews views_;
  Thumbnails thumbnails_;
  RepeatedWarning skipped_{"frames skipped"}, without_truth_{"frames without a ground-truth pose"};
  Failures failures_;
  FrameFacts facts_;
  std::optional<FinalRefinement> refinement_;
  std::optional<SurfelMap> final_map_;
  std::optional<double> final_map_s_;
  bool is_frame_complete_ = true;  // false after an exception within a frame
};

}  // namespace

SlamRunSummary RunSlam(const SlamRunOptions& options, const std::atomic<bool>& interrupted,
                       const std::function<void(const SlamRunProgress&)>& progress,
                       const std::function<void(const SlamRunResult&)>& finished) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  SlamRunOptions run = options;
  // Global registration takes longer than the time between two frames of a camera.
  if (options.OffersFrames()) {
    run.slam.confident_inlier_ratio = 0;
    run.slam.real_time = true;
  }
  // Given poses are final: no frame is lost, and no loop is closed.
  if (run.poses != "track") run.slam.loops.enabled = run.slam.loops.relocalization = false;
  std::unique_ptr<RunSession> session;
  if (!run.session.empty()) session = std::make_unique<RunSession>(&run);
  SlamRun slam(run, session.get(), interrupted);
  SlamRunSummary summary = slam.Run(interrupted, progress);
  if (finished) finished(slam.result());
  return summary;
}

}  // namespace surfit
