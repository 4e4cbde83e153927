// Dense SLAM on an RGB-D sequence: trajectory, surfel map, figures and pictures.

#include <glog/logging.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <utility>

#include "apps/live/live_run.h"
#include "apps/live/live_server.h"
#include "common/console.h"
#include "common/outcomes.h"
#include "common/recorded_flags.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/slam_run.h"

namespace surfit::tools {
namespace {

struct Options {
  SlamRunOptions run;
  ServeOptions serve;

  void Visit(OptionVisitor& v) {
    v.AddPart(run, "run", "run");
    v.AddPart(serve, "serve", "live web page");
  }
};

void ShowRefinement(const SlamRunProgress& progress) {
  static ProgressLine line;
  line.Show(Concat("refining poses and camera: round ", progress.refinement_rounds), false);
}

void ShowFinalMap(const SlamRunProgress& progress) {
  static ProgressLine line;
  char text[200];
  std::snprintf(text, sizeof(text), "re-integrating with final poses: %d/%d  map %.2f M surfels",
                progress.frames_reintegrated, progress.frames_done,
                static_cast<double>(progress.map_points) * 1e-6);
  line.Show(text, progress.frames_reintegrated == progress.frames_done);
}

void ShowProgress(const SlamRunProgress& progress) {
  if (progress.frames_reintegrated > 0) return ShowFinalMap(progress);
  if (progress.refinement_rounds > 0) return ShowRefinement(progress);
  static ProgressLine line;
  const double fps = progress.frames_done / progress.elapsed_s;
  const double million_surfels = static_cast<double>(progress.map_points) * 1e-6;
  char text[200];
  if (progress.frames_total < 0) {
    std::snprintf(text, sizeof(text), "frame %d  %.1f fps  map %.2f M surfels",
                  progress.frames_done, fps, million_surfels);
  } else {
    std::snprintf(text, sizeof(text), "frame %d/%d  %.1f fps  map %.2f M surfels  %.0f s left",
                  progress.frames_done, progress.frames_total, fps, million_surfels,
                  (progress.frames_total - progress.frames_done) / fps);
  }
  line.Show(text, progress.frames_done == progress.frames_total);
}

void WarnAboutDegenerateFrames(const SlamRunSummary& s) {
  if (s.frames_degenerate == 0) return;
  LOG(WARNING) << "degenerate frames: " << s.frames_degenerate << " of " << s.frames_total
               << ". Their depth leaves directions open, as along a wall or a corridor. There the "
                  "pose follows colour and the predicted motion, and can slide (state in "
                  "frames.csv)";
}

void PrintLoops(const BackendCounts& c) {
  std::printf("%zu keyframes, %zu of %zu loop candidates accepted, %zu map corrections\n",
              c.keyframes, c.loops_accepted, c.loop_candidates, c.corrections);
  if (c.relocalisations > 0) std::printf("relocalised %zu times\n", c.relocalisations);
  if (c.disconnected_submaps > 0) {
    std::printf("%zu of %zu maps have no loop closure to the first map: they stay separate\n",
                c.disconnected_submaps, c.submaps);
  }
}

// Prints the ATE with other timestamps, if they differ.
void PrintOtherTimestamps(const SlamRunSummary& s) {
  if (s.sensor_latency_s != 0 && s.ate_without_latency) {
    std::printf("  %.4f m with the timestamps of the files, without the sensor latency of %g s\n",
                s.ate_without_latency->translation_m.rmse, s.sensor_latency_s);
  }
  if (s.time_offset && s.time_offset->offset_s != 0) {
    std::printf("  %.4f m with a time offset of %.4f s, which fits the ground truth best\n",
                s.time_offset->ate.translation_m.rmse, s.time_offset->offset_s);
  }
}

void PrintMount(const SlamRunSummary& s) {
  if (!s.mount) return;
  std::printf("  %.4f m with a fitted mount of %.4f m\n", s.mount->ate.translation_m.rmse,
              s.mount->true_body_in_estimated_m.norm());
  const std::string warning = MountWarning(*s.mount);
  if (!warning.empty()) LOG(WARNING) << warning;
}

const CalibrationRecord& LastCalibration(const SlamRunSummary& s) {
  return s.refinement && s.refinement->is_applied ? s.refinement->record : s.calibrations.back();
}

void PrintRefinement(const SlamRunSummary& s) {
  if (!s.refinement) return;
  const CalibrationRecord& record = s.refinement->record;
  if (s.refinement->is_applied) {
    std::printf("poses were refined with %zu keyframes in %.1f s\n", record.keyframes,
                s.refinement->seconds);
  } else if (record.summary.Succeeded()) {
    std::printf("poses were not refined: the calibration with %zu keyframes is %s\n",
                record.keyframes,
                s.refinement->held_out_gain > record.summary.calibration_limit ? "implausible"
                                                                               : "not confirmed");
  } else {
    std::printf("poses were not refined: %s, %zu keyframes\n",
                ToString(record.summary.termination).c_str(), record.keyframes);
  }
}

void PrintColorLatency(const SlamRunSummary& s, const std::string& output) {
  if (s.color_latency_s == 0) return;
  std::printf(
      "colour was captured %.1f ms %s than its timestamps (standard deviation %.1f ms), see "
      "%s/camera.yaml\n",
      1e3 * std::abs(s.color_latency_s), s.color_latency_s > 0 ? "earlier" : "later",
      1e3 * s.calibrations.back().color_latency.sigma_s, output.c_str());
}

void PrintCalibration(const SlamRunSummary& s, const std::string& output) {
  if (s.calibrations.empty()) return;
  PrintColorLatency(s, output);
  const CalibrationRecord& last = LastCalibration(s);
  if (!s.calibration) {
    std::printf("the input calibration is kept: no significant difference with %zu keyframes\n",
                last.keyframes);
    return;
  }
  const PinholeCamera& camera = s.calibration->camera;
  std::printf("the calibration differs from the input: fx %.1f fy %.1f cx %.1f cy %.1f", camera.fx,
              camera.fy, camera.cx, camera.cy);
  if (const Eigen::MatrixXd& covariance = last.summary.calibration_covariance;
      covariance.size() > 0) {
    const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
    std::printf(" (standard deviations %.1f %.1f %.1f %.1f px)", sigma[0], sigma[1], sigma[2],
                sigma[3]);
  }
  std::printf("; all values are in %s/camera.yaml\n", output.c_str());
  if (!s.calibration_warning.empty())
    std::cerr << "warning: " << s.calibration_warning << std::endl;
}

void WarnAboutMovingObjects(const SlamRunSummary& s) {
  if (s.frames_with_two_motions > 0) {
    std::fprintf(
        stderr,
        "warning: frames that show two motions: %d. Their poses may be wrong: the camera may be "
        "registered to a moving object (two_motions in frames.csv)\n",
        s.frames_with_two_motions);
  }
  if (20 * s.frames_with_motion <= s.frames_total && s.frames_lost_in_motion == 0) return;
  std::fprintf(stderr,
               "warning: frames where moving objects cover more than 10 %% of the view, and are "
               "excluded from tracking and map: %d; frames lost after such frames: %d\n",
               s.frames_with_motion, s.frames_lost_in_motion);
}

void PrintSession(const SlamRunSummary& s, const SlamRunOptions& options) {
  if (options.session.empty()) return;
  if (const auto& found = s.localization) {
    std::printf(
        "localised in %s: %d of %d frames, %d relocalisations, longest loss %.2f s; standard "
        "deviation %.1f mm, %.2f deg\n",
        options.session.c_str(), found->frames, s.frames_total, found->relocalisations,
        found->longest_loss_s, 1e3 * found->median_sigma_m, found->median_sigma_rad * 180 / M_PI);
    return;
  }
  std::printf("session %s is saved; the run waited %lld times for the disk\n",
              options.session.c_str(), static_cast<long long>(s.session_waits));
}

void PrintSummary(const SlamRunSummary& s, const SlamRunOptions& options) {
  const std::string& output = options.output;
  std::printf("%s: %d frames, %d tracked, %d lost, %d skipped%s\n", output.c_str(), s.frames_total,
              s.frames_tracked, s.frames_lost, s.frames_skipped,
              s.interrupted ? ", interrupted" : "");
  if (s.frames_dropped > 0) {
    std::printf("%d frames were dropped, because the run was too slow\n", s.frames_dropped);
  }
  if (s.frames_with_longer_map_period > 0) {
    std::printf(
        "frames arrived too fast: during %d frames only a part was fused, at worst one of %d\n",
        s.frames_with_longer_map_period, s.longest_map_period);
  }
  if (s.pauses > 0) {
    std::printf("the camera was disconnected %d times, %.1f s in total\n", s.pauses, s.paused_s);
  }
  if (s.frames_without_intensities > 0) {
    std::printf("%d frames without intensities, tracked by geometry only\n",
                s.frames_without_intensities);
  }
  std::printf("updated %lld, added %lld, removed %lld, total points %zu, compression %.1f : 1\n",
              static_cast<long long>(s.updated), static_cast<long long>(s.added),
              static_cast<long long>(s.removed), s.map_points, s.compression_ratio);
  if (s.refused > 0) {
    std::printf("the map is full: %lld surfels were rejected (--max_map_points)\n",
                static_cast<long long>(s.refused));
  }
  const bool closes_loops = options.slam.loops.enabled || !options.session.empty() ||
                            s.loops.relocalisations > 0 || s.loops.submaps > 1;
  if (closes_loops && !options.localize) PrintLoops(s.loops);
  PrintSession(s, options);
  WarnAboutMovingObjects(s);
  WarnAboutDegenerateFrames(s);
  PrintCalibration(s, output);
  if (s.evaluation && s.evaluation->ate) {
    std::printf("ATE RMSE %.4f m over %.1f %% of the frames\n",
                s.evaluation->ate->translation_m.rmse, 100 * s.evaluation->coverage);
    PrintOtherTimestamps(s);
    PrintMount(s);
  } else if (s.evaluation && s.evaluation->expected == 0) {
    std::printf("ATE unknown: no frame has ground truth at its timestamp\n");
  } else if (s.evaluation) {
    std::printf("ATE unknown: %d of %d frames with ground truth have a pose, must be at least 3\n",
                s.evaluation->matched, s.evaluation->expected);
  } else {
    std::printf("ATE unknown: no ground truth\n");
  }
  PrintRefinement(s);
  if (s.final_map_s) {
    std::printf("the map was re-integrated with the final poses in %.1f s\n", *s.final_map_s);
  }
  std::printf("%.1f s in total\n", s.total_s);
}

void PrintTimes(const char* name, const TimeStatistics& times, double share) {
  std::printf("%-10s %9.1f %9.1f %9.1f %7.1f %%\n", name, times.mean_ms, times.median_ms,
              times.p95_ms, 100 * share);
}

void PrintStages(const SlamRunSummary& s, bool offered) {
  std::printf("%-10s %9s %9s %9s %9s\n", "stage", "mean ms", "median ms", "p95 ms", "of time");
  for (const StageStatistics& stage : s.stages) {
    PrintTimes(stage.name.c_str(), stage.times, stage.share);
  }
  PrintTimes("frame", s.frame, 1);  // less than the sum if decoding runs in parallel
  if (!offered) return;
  const TimeStatistics &pose = s.pose_latency, &whole = s.latency;
  std::printf("to pose    %9.1f %9.1f %9.1f, from arrival to pose\n", pose.mean_ms, pose.median_ms,
              pose.p95_ms);
  std::printf("latency    %9.1f %9.1f %9.1f, from arrival to fusion\n", whole.mean_ms,
              whole.median_ms, whole.p95_ms);
}

void AddViewers(const Options& options, LiveRun* run) {
  if (options.serve.port < 0) return;
  auto server = std::make_unique<LiveServer>(options.serve, run);
  std::cerr << "watch the run at " << server->url() << std::endl;
  run->Add(std::move(server));
}

int Run(const Options& all) {
  const SlamRunOptions& options = all.run;
  const std::atomic<bool>& interrupted = CatchInterruptions();
  LiveRun live_run(interrupted, Interrupt);
  AddViewers(all, &live_run);
  const auto progress = [&](const SlamRunProgress& now) {
    ShowProgress(now);
    live_run.Update(now);
  };
  const auto keep = [&](const SlamRunResult& result) { live_run.Keep(result); };
  const SlamRunSummary summary = RunSlam(options, interrupted, progress, keep);
  const bool live = IsLive(options.sequence);
  if (summary.interrupted || live) std::fputc('\n', stderr);  // ends the progress line
  PrintSummary(summary, options);
  PrintStages(summary, options.OffersFrames());
  if (options.keep_views) WriteAndPrintReport({{options.output}, options.output + "/report.html"});
  std::fflush(stdout);
  live_run.Stay();
  if (!summary.MostFramesHaveAPose() && !summary.interrupted) {
    std::fprintf(stderr, "failed: only %d of %d frames have a pose\n", summary.frames_tracked,
                 summary.frames_total);
    return kAlgorithmFailed;
  }
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(argc, argv, "dense SLAM over an RGB-D sequence on the CPU",
                                 surfit::tools::Run);
}
