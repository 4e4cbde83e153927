// Compares pose solvers, residuals and associations: what they cost and from where they converge.

#include <gflags/gflags.h>

#include <atomic>
#include <cstdio>
#include <optional>

#include "common/interruption.h"
#include "common/lists.h"
#include "common/progress_line.h"
#include "common/sequence_flags.h"
#include "common/slam_flags.h"
#include "common/text_table.h"
#include "common/tool_main.h"
#include "surfit/registration/register_clouds.h"
#include "surfit/run/compare_solvers.h"

namespace {

const surfit::CompareOptions kRun;

}  // namespace

DEFINE_int32(synthetic_points, kRun.synthetic_points,
             "compare on so many random points whose pairs are known, without a robust kernel");
DEFINE_double(noise_m, kRun.noise_m, "standard deviation of these points' coordinates");
DEFINE_int32(pairs, kRun.pairs,
             "pairs of frames of the sequence, evenly spread; 0 = none, with --slam");
DEFINE_int32(gap, kRun.gap, "frames from the source to the target of a pair");
DEFINE_bool(slam, kRun.slam,
            "also run SLAM over all of these frames with each combination, and compare the maps");
DEFINE_string(source, kRun.source, "compare on two clouds: the one to be moved, PLY or PCD");
DEFINE_string(target, kRun.target, "and the one to be met");
DEFINE_string(truth, kRun.truth,
              "true target_from_source of the clouds as tx,ty,tz,qx,qy,qz,qw; empty = unknown");
DEFINE_int32(first, kRun.sequence.first, "index of the first frame to use");
DEFINE_int32(last, kRun.sequence.last,
             "index of the last frame to use, inclusive; -1 = to the end");
DEFINE_string(replay, kRun.replay,
              "compare on a frame that tracking lost: a folder frame-XXXXXX of surfit_slam "
              "--dump_failures, which brings its own start and options of registration");
DEFINE_string(output, kRun.output, "folder for tables and pictures; made if missing");
DEFINE_string(solvers, "",
              "pose solvers, with commas between them; empty = all, of which ceres_per_point on "
              "known pairs only");
DEFINE_string(linear_solvers, "", "linear solvers of ceres_per_point; empty = all");
DEFINE_string(residuals, "", "residuals; empty = all");
DEFINE_string(associations, "", "associations; empty = all that the data allows");
DEFINE_string(threads, surfit::tools::Joined(kRun.threads),
              "numbers of threads that compute at the same time, a row for each");
DEFINE_string(rotations_deg, surfit::tools::Joined(kRun.rotations_deg),
              "angles that starts are turned by from the truth");
DEFINE_string(translations_m, surfit::tools::Joined(kRun.translations_m),
              "distances that they are shifted by, each with each angle");
DEFINE_uint64(seed, kRun.seed, "seed of the axes of turns and shifts, and of random points");
DEFINE_double(max_rotation_error_deg, kRun.max_rotation_error_deg,
              "what ends nearer to the truth counts as converged");
DEFINE_double(max_translation_error_m, kRun.max_translation_error_m,
              "what ends nearer to the truth counts as converged");

namespace surfit::tools {
namespace {

CompareOptions OptionsFromFlags() {
  CompareOptions options;
  const bool clouds = !FLAGS_source.empty() || !FLAGS_target.empty();
  const IcpOptions base = clouds ? RegisterCloudsOptions::DefaultIcp() : IcpOptions();
  SetIcpFlagDefaults(base);
  options.synthetic_points = FLAGS_synthetic_points;
  options.noise_m = FLAGS_noise_m;
  options.sequence = SequenceOptionsFromFlags();
  options.sequence.first = FLAGS_first;
  options.sequence.last = FLAGS_last;
  options.pairs = FLAGS_pairs;
  options.gap = FLAGS_gap;
  options.slam = FLAGS_slam;
  options.source = FLAGS_source;
  options.target = FLAGS_target;
  options.truth = FLAGS_truth;
  options.replay = FLAGS_replay;
  options.output = FLAGS_output;
  options.solvers = Names(FLAGS_solvers);
  options.linear_solvers = Names(FLAGS_linear_solvers);
  options.residuals = Names(FLAGS_residuals);
  options.associations = Names(FLAGS_associations);
  options.threads = IntegerList("threads", FLAGS_threads);
  options.rotations_deg = NumberList("rotations_deg", FLAGS_rotations_deg);
  options.translations_m = NumberList("translations_m", FLAGS_translations_m);
  options.seed = FLAGS_seed;
  options.max_rotation_error_deg = FLAGS_max_rotation_error_deg;
  options.max_translation_error_m = FLAGS_max_translation_error_m;
  options.preprocess = PreprocessOptionsFromFlags();
  options.icp = FrameIcpOptionsFromFlags(base);
  return options;
}

void ShowProgress(const CompareProgress& progress) {
  static ProgressLine line;
  const int left = progress.total - progress.done;
  char text[100];
  std::snprintf(text, sizeof(text), "%s %d/%d  %.0f s left", progress.unit.c_str(), progress.done,
                progress.total, progress.elapsed_s / progress.done * left);
  line.Show(text, progress.elapsed_s, left == 0);
}

// "-" for what does not apply.
std::string Cell(const char* format, const std::optional<double>& value, double scale = 1) {
  if (!value) return "-";
  char text[50];
  std::snprintf(text, sizeof(text), format, scale * *value);
  return text;
}

void PrintTable(const std::vector<ComparisonRow>& rows) {
  std::vector<std::vector<std::string>> table = {
      {"association", "residual", "solver", "threads", "points", "runs", "build ms", "linearize ms",
       "solve ms", "total ms", "iterations", "final cost", "error deg", "error mm", "converged",
       "ended mostly as"}};
  for (const ComparisonRow& row : rows) {
    table.push_back(
        {row.combination.association, row.combination.residual, row.combination.SolverTitle(),
         std::to_string(row.threads), std::to_string(row.points), std::to_string(row.runs),
         Cell("%.2f", row.build_ms), Cell("%.2f", row.linearize_ms), Cell("%.2f", row.solve_ms),
         Cell("%.2f", row.total_ms), Cell("%.4g", row.iterations), Cell("%.5g", row.final_cost),
         Cell("%.2g", row.rotation_error_deg), Cell("%.2g", row.translation_error_m, 1000),
         Cell("%.0f %%", row.converged_share, 100),
         row.termination.empty() ? "-" : row.termination});
  }
  std::fputs(TextTable(table, 3).c_str(), stdout);
}

void PrintSlamTable(const std::vector<SlamComparisonRow>& rows) {
  std::vector<std::vector<std::string>> table = {
      {"SLAM", "residual", "solver", "threads", "frames", "lost", "ATE mm", "frame ms", "track ms",
       "surfels", "surface mean mm", "p90 mm", "shared"}};
  for (const SlamComparisonRow& row : rows) {
    table.push_back(
        {row.combination.association, row.combination.residual, row.combination.SolverTitle(),
         std::to_string(row.threads), std::to_string(row.frames), std::to_string(row.frames_lost),
         Cell("%.2f", row.ate_m, 1000), Cell("%.1f", row.frame_ms), Cell("%.1f", row.track_ms),
         std::to_string(row.map_points), Cell("%.3f", row.surface_distance_mean_m, 1000),
         Cell("%.3f", row.surface_distance_p90_m, 1000), Cell("%.1f %%", row.shared_surface, 100)});
  }
  std::fputs(TextTable(table, 3).c_str(), stdout);
  std::printf("Surfaces are compared with those of the first solver with the same residual.\n");
}

int Run() {
  const CompareOptions options = OptionsFromFlags();
  const std::atomic<bool>& interrupted = CatchInterruptions();
  const Comparison comparison = CompareSolvers(options, interrupted, ShowProgress);
  if (interrupted) std::fputc('\n', stderr);  // ends the line of progress
  if (!comparison.rows.empty()) PrintTable(comparison.rows);
  if (!comparison.slam.empty()) PrintSlamTable(comparison.slam);
  for (const std::string& note : comparison.notes) std::printf("Note: %s.\n", note.c_str());
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "compares pose solvers, residuals and associations from starts around the truth: times, "
      "iterations, final errors and the share that converged",
      surfit::tools::Run);
}
