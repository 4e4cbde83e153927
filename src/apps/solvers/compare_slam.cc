
#include "apps/solvers/comparison_files.h"
#include "apps/solvers/pose_problem.h"
#include "output/output_files.h"
#include "registration/solvers/pair_solver.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/io/point_cloud.h"
#include "surfit/run/slam_run.h"

namespace surfit {
namespace {

SlamRunOptions RunOptionsOf(const CompareOptions& options, const SolverCombination& combination,
                            int threads) {
  SlamRunOptions run;
  run.sequence = options.sequence;
  run.slam.preprocess = options.preprocess;
  run.slam.icp = options.icp;
  SetCombination(combination, &run.slam.icp);
  run.threads = threads;
  run.pictures = false;
  std::string name = combination.solver;
  if (!combination.linear_solver.empty()) name += "-" + combination.linear_solver;
  run.output = Concat(options.output, "/slam/", name, "-", combination.residual, "-",
                      combination.association, "-", threads);
  return run;
}

SlamComparisonRow RowOf(const SlamRunSummary& summary, const SolverCombination& combination,
                        int threads) {
  SlamComparisonRow row;
  row.combination = combination;
  row.threads = threads;
  row.frames = summary.frames_total;
  row.frames_lost = summary.frames_lost;
  if (summary.evaluation && summary.evaluation->ate) {
    row.ate_m = summary.evaluation->ate->translation_m.rmse;
  }
  row.frame_ms = summary.frame.mean_ms;
  for (const StageStatistics& stage : summary.stages) {
    if (stage.name == "track") row.track_ms = stage.times.mean_ms;
  }
  row.map_points = summary.map_points;
  return row;
}

void CompareMaps(const PointCloud& map, const PointCloud& reference, SlamComparisonRow* row) {
  if (map.points.empty() || reference.points.empty()) return;
  const MapError error = ComputeMapError(map.points, reference.points, reference.normals, {});
  row->surface_distance_mean_m = error.plane_accuracy_m->mean;
  row->surface_distance_p90_m = error.plane_accuracy_m->p90;
  row->shared_surface = error.completeness;
}

}  // namespace

std::vector<SlamComparisonRow> CompareSlam(
    const CompareOptions& options, const std::atomic<bool>& interrupted,
    const std::function<void(const CompareProgress&)>& progress) {
  const std::vector<SolverCombination> combinations = SolverCombinations(options);
  const int runs = static_cast<int>(combinations.size() * options.threads.size());
  const Stopwatch time;
  std::vector<SlamComparisonRow> rows;
  PointCloud reference;
  for (const SolverCombination& combination : combinations) {
    for (const int threads : options.threads) {
      if (interrupted) return rows;
      const SlamRunOptions run = RunOptionsOf(options, combination, threads);
      const int before = static_cast<int>(rows.size());
      const SlamRunSummary summary = RunSlam(run, interrupted, [&](const SlamRunProgress& p) {
        progress({"frame", before * p.frames_total + p.frames_done, runs * p.frames_total,
                  1e-3 * time.Milliseconds()});
      });
      if (summary.interrupted) return rows;  // an interrupted run has fewer frames
      rows.push_back(RowOf(summary, combination, threads));
      const PointCloud map = ReadPly(run.output + "/map.ply");
      const bool comparable = before > 0 &&
                              rows[before - 1].combination.residual == combination.residual &&
                              rows[before - 1].combination.association == combination.association;
      if (!comparable) reference = map;
      CompareMaps(map, reference, &rows.back());
    }
  }
  return rows;
}

}  // namespace surfit
