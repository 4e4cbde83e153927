// Dense SLAM over a recorded sequence: trajectory, surfel map, figures and pictures.

#include <gflags/gflags.h>

#include <atomic>
#include <cstdio>
#include <memory>

#include "common/interruption.h"
#include "common/progress_line.h"
#include "common/recorded_flags.h"
#include "common/refinement.h"
#include "common/report.h"
#include "common/sequence_flags.h"
#include "common/slam_flags.h"
#include "common/solver_flags.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/slam_run.h"
#include "view/live_view.h"

namespace {

const surfit::SlamRunOptions kRun;
constexpr double kDegree = 3.14159265358979323846 / 180;

}  // namespace

DEFINE_int32(first, kRun.sequence.first, "index of the first frame to read");
DEFINE_int32(last, kRun.sequence.last,
             "index of the last frame to read, inclusive; -1 = to the end");
DEFINE_int32(stride, kRun.sequence.stride, "read every stride-th frame");
DEFINE_string(output, kRun.output, "folder for the results; made if missing");
DEFINE_string(initial_pose, kRun.initial_pose,
              "pose of the first frame: identity, groundtruth or tx,ty,tz,qx,qy,qz,qw");
DEFINE_string(poses, kRun.poses, "track, or groundtruth: fuse along the sequence's own poses");
DEFINE_string(tracking, kRun.slam.tracking, "frame_to_model or frame_to_frame");
DEFINE_string(
    motion_model, kRun.slam.motion_model,
    "where tracking starts: constant_velocity, constant_pose, or so3 (the last pose, turned so "
    "that small images are most alike)");
DEFINE_string(initialize, kRun.slam.initialize,
              "how a frame that tracking would lose is found from the last good one: so3, features "
              "(see surfit_align), or identity: not at all");
DEFINE_int32(map_period, kRun.slam.map_period,
             "of so many frames one is fused, and for one the map is drawn to register it and the "
             "next to; 1 = every frame");
DEFINE_double(max_view_shift, kRun.slam.max_view_shift,
              "the map is drawn anew where the image is expected to have moved by more, as a share "
              "of its width");
DEFINE_int32(
    min_source_rows, kRun.slam.icp.min_source_rows,
    "on the finest level so few rows of the frame are registered as leave this many, evenly "
    "spaced; 0 = all");
DEFINE_double(min_turn_eigenvalue, kRun.slam.min_turn_eigenvalue,
              "after a frame that holds a direction of motion less than this, nothing takes turns "
              "and all rows are registered; 0 = never");
DEFINE_bool(
    loop_closure, kRun.slam.loops.enabled,
    "close loops: find places again, correct the poses and let the map follow; a lost camera "
    "is looked for everywhere");
DEFINE_int32(
    new_map_after, kRun.slam.loops.new_map_after,
    "with loop_closure: after so many lost frames in a row a new map is begun, and joined to "
    "the first by a loop; 0 = never");
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time, reading included");
DEFINE_double(
    offered_fps, kRun.offered_fps,
    "frames are offered at this rate, as by a camera: those not taken in time are dropped "
    "and counted; 0 = as fast as they are processed");
DEFINE_bool(pictures, kRun.pictures, "write the pictures");
DEFINE_bool(view, false,
            "show the run in a window: frame, model, map and camera path; without a display the "
            "run says so and goes on");
DEFINE_bool(report, kRun.keep_views,
            "write report.html, to be opened in a browser: map and trajectory in 3D, plots, views, "
            "options");
DEFINE_bool(refine, false,
            "in the end refine the keyframes' poses, the map and the camera's calibration, to the "
            "folder refined in the output's; surfit_refine has more options");
DEFINE_string(trace, kRun.trace,
              "file for the times of all stages and threads, as ui.perfetto.dev and "
              "chrome://tracing show them; empty = none");
DEFINE_string(dump_failures, kRun.dump_failures,
              "folder that keeps what tracking lost a frame with, for surfit_compare_solvers "
              "--replay; empty = none");
DEFINE_double(min_inlier_share, kRun.slam.min_inlier_share,
              "a frame with a smaller share of paired points is lost");
DEFINE_double(max_rmse_m, kRun.slam.max_rmse_m, "a frame with larger residuals is lost");
DEFINE_string(weighting, kRun.slam.fusion.weighting,
              "weight of a point in the map: confidence (less off the centre) or uniform");
DEFINE_double(merge_distance_m, kRun.slam.fusion.max_distance_m,
              "points merge with surfels at most this far along the normal");
DEFINE_double(merge_angle_deg, kRun.slam.fusion.max_normal_angle_rad / kDegree,
              "points merge with surfels whose normal differs by at most this");
DEFINE_double(max_spacing_m, kRun.slam.fusion.max_spacing_m,
              "points merge with surfels at most this far across the surface");
DEFINE_double(double_share, kRun.slam.fusion.double_share,
              "of two surfels closer across the surface than this share of their radii, and of "
              "max_spacing_m, the one of less confidence is removed; 0 = none");
DEFINE_double(lasting_confidence, kRun.slam.fusion.lasting_confidence,
              "surfels of less confidence are removed when not seen for a while");
DEFINE_double(free_space_margin_m, kRun.slam.fusion.free_space_margin_m,
              "surfels are removed where depth is measured farther than this behind them");
DEFINE_int32(active_frames, kRun.slam.fusion.active_frames,
             "surfels not seen in so many fused frames are neither tracked against nor merged "
             "with; 0 = no limit; with loop_closure what loops need");
DEFINE_int32(max_map_points, kRun.slam.fusion.max_map_points,
             "a map of so many surfels takes no further ones, which is said and counted; 0 = no "
             "limit");
DEFINE_int32(max_dormant_frames, kRun.slam.fusion.max_dormant_frames,
             "these surfels are removed when not seen for longer");

namespace surfit::tools {
namespace {

SlamRunOptions OptionsFromFlags() {
  SlamRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.sequence.first = FLAGS_first;
  options.sequence.last = FLAGS_last;
  options.sequence.stride = FLAGS_stride;
  options.output = FLAGS_output;
  options.initial_pose = FLAGS_initial_pose;
  options.poses = FLAGS_poses;
  options.threads = FLAGS_threads;
  options.offered_fps = FLAGS_offered_fps;
  options.pictures = FLAGS_pictures;
  options.keep_views = FLAGS_report;
  options.trace = FLAGS_trace;
  options.dump_failures = FLAGS_dump_failures;
  SlamOptions& slam = options.slam;
  slam.preprocess = PreprocessOptionsFromFlags();
  slam.icp = FrameIcpOptionsFromFlags(kRun.slam.icp);
  SetSolverFromFlags(&slam.icp);
  slam.icp.min_source_rows = FLAGS_min_source_rows;
  slam.min_turn_eigenvalue = FLAGS_min_turn_eigenvalue;
  slam.map_period = FLAGS_map_period;
  slam.max_view_shift = FLAGS_max_view_shift;
  slam.tracking = FLAGS_tracking;
  slam.motion_model = FLAGS_motion_model;
  slam.initialize = FLAGS_initialize;
  slam.loops.enabled = FLAGS_loop_closure;
  slam.loops.new_map_after = FLAGS_new_map_after;
  slam.min_inlier_share = FLAGS_min_inlier_share;
  slam.max_rmse_m = FLAGS_max_rmse_m;
  slam.fusion.noise = slam.preprocess.noise;
  slam.fusion.weighting = FLAGS_weighting;
  slam.fusion.max_distance_m = static_cast<float>(FLAGS_merge_distance_m);
  slam.fusion.max_normal_angle_rad = static_cast<float>(FLAGS_merge_angle_deg * kDegree);
  slam.fusion.max_spacing_m = static_cast<float>(FLAGS_max_spacing_m);
  slam.fusion.double_share = static_cast<float>(FLAGS_double_share);
  slam.fusion.lasting_confidence = static_cast<float>(FLAGS_lasting_confidence);
  slam.fusion.free_space_margin_m = static_cast<float>(FLAGS_free_space_margin_m);
  slam.fusion.active_frames = FLAGS_active_frames;
  slam.fusion.max_map_points = FLAGS_max_map_points;
  slam.fusion.max_dormant_frames = FLAGS_max_dormant_frames;
  options.record = RecordedFlags();
  return options;
}

void ShowProgress(const SlamRunProgress& progress) {
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
  line.Show(text, progress.elapsed_s, progress.frames_done == progress.frames_total);
}

void PrintLoops(const BackendCounts& c) {
  std::printf("%zu keyframes, %zu loops accepted of %zu tried, %zu corrections of the map\n",
              c.keyframes, c.loops_accepted, c.loops_proposed, c.corrections);
  if (c.relocalisations > 0) std::printf("lost and found again %zu times\n", c.relocalisations);
  if (c.submaps_apart > 0) {
    std::printf("%zu of %zu maps could not be joined to the first: they stand beside it\n",
                c.submaps_apart, c.submaps);
  }
}

void PrintSummary(const SlamRunSummary& s, const std::string& output) {
  std::printf("%s: %d frames, %d tracked, %d lost, %d skipped%s\n", output.c_str(), s.frames_total,
              s.frames_tracked, s.frames_lost, s.frames_skipped,
              s.interrupted ? ", interrupted" : "");
  if (s.frames_dropped > 0) {
    std::printf("%d frames were offered, but not taken in time\n", s.frames_dropped);
  }
  if (s.frames_without_intensities > 0) {
    std::printf("%d frames without intensities, tracked by their shapes alone\n",
                s.frames_without_intensities);
  }
  std::printf("updated %lld, added %lld, removed %lld, total points %zu, compression %.1f : 1\n",
              static_cast<long long>(s.updated), static_cast<long long>(s.added),
              static_cast<long long>(s.removed), s.map_points, s.compression_ratio);
  if (s.refused > 0) {
    std::printf("the map is full: %lld surfels found no place (--max_map_points)\n",
                static_cast<long long>(s.refused));
  }
  if (s.loops.keyframes > 0) PrintLoops(s.loops);
  if (s.evaluation && s.evaluation->ate) {
    std::printf("ATE RMSE %.4f m over %.1f %% of the frames\n",
                s.evaluation->ate->translation_m.rmse, 100 * s.evaluation->coverage);
  } else if (s.evaluation) {
    std::printf("ATE unknown: %d of %d frames with ground truth have a pose, 3 must have one\n",
                s.evaluation->matched, s.evaluation->expected);
  } else {
    std::printf("ATE unknown: no ground truth\n");
  }
  std::printf("%.1f s in all\n", s.total_s);
}

void PrintTimes(const char* name, const TimeStatistics& times, double share) {
  std::printf("%-10s %9.1f %9.1f %9.1f %7.1f %%\n", name, times.mean_ms, times.median_ms,
              times.p95_ms, 100 * share);
}

void PrintStages(const SlamRunSummary& s) {
  std::printf("%-10s %9s %9s %9s %9s\n", "stage", "mean ms", "median ms", "p95 ms", "of time");
  for (const StageStatistics& stage : s.stages) {
    PrintTimes(stage.name.c_str(), stage.times, stage.share);
  }
  PrintTimes("frame", s.frame, 1);  // less than their sum where decode runs beside the others
  if (FLAGS_offered_fps == 0) return;
  std::printf("latency    %9.1f %9.1f %9.1f, from being offered on\n", s.latency.mean_ms,
              s.latency.median_ms, s.latency.p95_ms);
}

// Of the run that has just been written.
int Refine(const SlamRunOptions& run) {
  RefineRunOptions options;
  options.sequence = run.sequence;
  options.trajectory = run.output + "/trajectory.txt";
  options.output = run.output + "/refined";
  options.preprocess = run.slam.preprocess;
  options.refinement.error_model.noise = run.slam.preprocess.noise;
  options.threads = run.threads;
  options.record = run.record;
  return RefineAndPrint(options);
}

int Run() {
  const SlamRunOptions options = OptionsFromFlags();
  if (FLAGS_refine && options.sequence.format == "watch") {
    throw InputError("refine reads the sequence once more, which format 'watch' cannot");
  }
  const std::atomic<bool>& interrupted = CatchInterruptions();
  const std::unique_ptr<LiveView> view = FLAGS_view ? LiveView::Open(interrupted) : nullptr;
  const auto progress = [&](const SlamRunProgress& now) {
    ShowProgress(now);
    if (view) view->Update(now);
  };
  const SlamRunSummary summary = RunSlam(options, interrupted, progress);
  const bool live = options.sequence.format == "watch";
  if (summary.interrupted || live) std::fputc('\n', stderr);  // ends the line of progress
  PrintSummary(summary, options.output);
  PrintStages(summary);
  if (FLAGS_report) WriteAndPrintReport({{options.output}, options.output + "/report.html"});
  const bool nothing_tracked = summary.frames_tracked <= 1 && summary.frames_lost > 0;
  if (nothing_tracked && !summary.interrupted) return kAlgorithmFailed;
  return FLAGS_refine ? Refine(options) : kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::SetIcpFlagDefaults(kRun.slam.icp);
  return surfit::tools::ToolMain(argc, argv, "dense SLAM over an RGB-D sequence on the CPU",
                                 surfit::tools::Run);
}
