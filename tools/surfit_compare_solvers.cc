// Compares cost and convergence of pose solvers, residuals and associations.

#include <atomic>
#include <cstdio>
#include <optional>

#include "apps/solvers/compare_solvers.h"
#include "common/console.h"
#include "common/recorded_flags.h"
#include "common/settings_text.h"
#include "common/tool_main.h"
#include "surfit/registration/register_clouds.h"

namespace surfit::tools {
namespace {

struct Options {
  CompareOptions compare;

  void Visit(OptionVisitor& v) {
    v.AddPart(compare, "compare", "comparison");
    v.Group("problem");
    PairText points(Option("synthetic_points", "", AtLeast(0)), &compare.synthetic_points,
                    Option("noise_m", "", AtLeast(0)), &compare.noise_m);
    v.AddText(points,
              Option("synthetic_points",
                     "POINTS,NOISE: compare on this number of random points with known "
                     "correspondences, without robust kernel; NOISE: standard deviation of the "
                     "coordinates, also in the error model, m; 0: no points",
                     Everyday()));
    PairText pairs(Option("pairs", "", AtLeast(0)), &compare.pairs, Option("gap", "", AtLeast(1)),
                   &compare.gap);
    v.AddText(pairs, Option("pairs",
                            "PAIRS,GAP: number of frame pairs, evenly spread over the sequence, "
                            "and number of frames from source to target; 0: none, requires slam",
                            Everyday()));
  }
};

void ShowProgress(const CompareProgress& progress) {
  static ProgressLine line;
  const int left = progress.total - progress.done;
  char text[100];
  std::snprintf(text, sizeof(text), "%s %d/%d  %.0f s left", progress.unit.c_str(), progress.done,
                progress.total, progress.elapsed_s / progress.done * left);
  line.Show(text, left == 0);
}

// "-" for a missing value.
std::string Cell(const char* format, const std::optional<double>& value, double scale = 1) {
  if (!value) return "-";
  char text[50];
  std::snprintf(text, sizeof(text), format, scale * *value);
  return text;
}

// Ratio of converged runs with its 95 % interval, in percent.
std::string Converged(const ComparisonRow& row) {
  const std::string ratio = Cell("%.0f %%", row.converged_ratio, 100);
  if (!row.converged_low) return ratio;
  return ratio + Cell(" (%.0f", row.converged_low, 100) + Cell("-%.0f)", row.converged_high, 100);
}

void PrintTable(const std::vector<ComparisonRow>& rows) {
  std::vector<std::vector<std::string>> table = {
      {"association", "residual", "solver", "threads", "points", "runs", "build ms", "linearize ms",
       "solve ms", "total ms", "iterations", "iteration ms", "memory MB", "final cost", "error deg",
       "error mm", "converged", "usual termination"}};
  for (const ComparisonRow& row : rows) {
    table.push_back(
        {row.combination.association, row.combination.residual, row.combination.SolverTitle(),
         std::to_string(row.threads), std::to_string(row.points), std::to_string(row.runs),
         Cell("%.2f", row.build_ms), Cell("%.2f", row.linearize_ms), Cell("%.2f", row.solve_ms),
         Cell("%.2f", row.total_ms), Cell("%.4g", row.iterations), Cell("%.1f", row.iteration_ms),
         Cell("%.1f", row.memory_bytes, 1e-6),
         Cell(row.iteration_ms ? "%.9g" : "%.5g", row.final_cost),
         Cell("%.2g", row.rotation_error_deg), Cell("%.2g", row.translation_error_m, 1000),
         Converged(row), row.termination.empty() ? "-" : row.termination});
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

int Run(const Options& options) {
  const std::atomic<bool>& interrupted = CatchInterruptions();
  const Comparison comparison = CompareSolvers(options.compare, interrupted, ShowProgress);
  if (interrupted) std::fputc('\n', stderr);  // ends the progress line
  if (!comparison.rows.empty()) PrintTable(comparison.rows);
  if (!comparison.slam.empty()) PrintSlamTable(comparison.slam);
  for (const std::string& note : comparison.notes) std::printf("Note: %s.\n", note.c_str());
  return kDone;
}

void Prepare(Options* options) {
  CompareOptions& compare = options->compare;
  if (!compare.run.empty()) ApplyRecordedFlags(compare.run, TableOf(&compare.sequence));
  const bool clouds = !compare.source.empty() || !compare.target.empty();
  if (clouds) compare.icp = RegisterCloudsOptions::DefaultIcp();
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "compares pose solvers, residuals and associations from initial poses around the truth: "
      "times, iterations, final errors and the ratio of converged runs, on frames of a sequence or "
      "two clouds; or the solvers of joint refinement on the keyframes of --run",
      surfit::tools::Run, surfit::tools::Prepare);
}
