#include "common/outcomes.h"

#include <cmath>
#include <cstdio>
#include <iostream>
#include <vector>

#include "common/console.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

std::string Failure(const IcpResult& icp, const IcpOptions& options) {
  switch (icp.termination) {
    case Termination::kTooFewInliers:
      return Concat("inlier share is ", icp.inlier_share, ", pairs must be at least min_inliers (",
                    options.min_inliers, ") and a share of ", options.min_inlier_share);
    case Termination::kSingularSystem:
      return Concat("the surfaces leave ", icp.free_directions.size(),
                    " direction(s) of motion free: smallest eigenvalue is ", icp.eigenvalues[0],
                    ", must be above min_eigenvalue (", options.held.min_eigenvalue,
                    ") and min_information_ratio (", options.held.min_information_ratio,
                    ") times what noise of the normals feigns");
    case Termination::kFreeSpaceFilled:
      return Concat("free-space share is ", icp.free_space_share,
                    ", must be at most max_free_space_share (", options.max_free_space_share, ")");
    case Termination::kConverged:
    case Termination::kRmseIncreased:
    case Termination::kMaxIterations:
      break;
  }
  return "";
}

using Row = std::vector<std::string>;

Row AteRow(const RefineRunSummary& s) {
  const auto text = [](const std::optional<TrajectoryEvaluation>& e) -> std::string {
    return e && e->ate ? Number(1000 * e->ate->translation_m.rmse, 4) : "unknown";
  };
  return {"ATE RMSE, mm", text(s.before), text(s.after), ""};
}

void AddCalibrationRows(const RefineRunSummary& s, std::vector<Row>* rows) {
  const DepthCalibration &a = s.given, &b = s.calibration;
  const auto add = [&](const std::string& name, double before, double after, int i) {
    const double variance = s.refinement.calibration_covariance(i, i);
    const std::string sigma = variance > 0 ? Number(std::sqrt(variance), 3) : "held";
    rows->push_back({name, Number(before), Number(after), sigma});
  };
  add("fx, px", a.camera.fx, b.camera.fx, 0);
  add("fy, px", a.camera.fy, b.camera.fy, 1);
  add("cx, px", a.camera.cx, b.camera.cx, 2);
  add("cy, px", a.camera.cy, b.camera.cy, 3);
  for (std::size_t i = 0; i < InverseDepthField::kSize; ++i) {
    add(Concat("inverse depth c", i, ", 1/m"), a.field.coefficients[i], b.field.coefficients[i],
        static_cast<int>(4 + i));
  }
  add("readout, s", a.readout_s, b.readout_s, static_cast<int>(4 + InverseDepthField::kSize));
}

// Whether the calibration is another one, and how it was told.
std::string CalibrationLine(const RefinementSummary& s) {
  if (s.calibration_limit == 0) return "";
  return Concat("the calibration that was found differs ",
                s.calibration_kept ? "by no more than noise would make it; the given one is kept"
                                   : "from the given one by more than noise",
                " (squared distance ", Number(s.calibration_distance, 3), ", limit ",
                Number(s.calibration_limit, 3), ")\n");
}

void PrintOutcome(const RefineRunSummary& s, const std::string& output) {
  std::vector<Row> rows = {{"", "before", "after", "standard deviation"}, AteRow(s)};
  const RefinementFit &first = s.refinement.before, &last = s.refinement.after;
  rows.push_back(
      {"point to plane RMS, mm", Number(1000 * first.rms_m, 4), Number(1000 * last.rms_m, 4), ""});
  AddCalibrationRows(s, &rows);
  std::cout << output << ": " << ToString(s.refinement.termination) << " after "
            << s.refinement.rounds.size() << " rounds, " << s.keyframes << " keyframes of "
            << s.poses << " poses, " << s.map_points << " surfels in the map, "
            << Number(s.total_s, 3) << " s\n"
            << TextTable(rows, 1) << CalibrationLine(s.refinement)
            << "scale is held: nothing in a sequence tells the size of the world" << std::endl;
}

}  // namespace

void PrintIterations(const IcpResult& icp) {
  int level = -1, count = 0;
  for (const IcpIteration& iteration : icp.iterations) {
    if (iteration.level != level) {
      std::printf("level %d\n", iteration.level);
      level = iteration.level;
      count = 0;
    }
    std::printf("iter %d: avg loss = %.4e, inlier count = %d\n", count++, iteration.average_loss,
                iteration.inlier_count);
  }
}

void PrintPose(const IcpResult& icp) {
  const Eigen::Matrix4d pose = icp.target_from_source.Matrix();
  std::printf("target_from_source =\n");
  for (int row = 0; row < 4; ++row) {
    std::printf("  %12.8f %12.8f %12.8f %12.8f\n", pose(row, 0), pose(row, 1), pose(row, 2),
                pose(row, 3));
  }
}

ExitCode PrintFailure(const IcpResult& icp, const IcpOptions& options) {
  if (icp.Succeeded()) return kDone;
  std::fprintf(stderr, "failed: %s: %s\n", ToString(icp.termination).c_str(),
               Failure(icp, options).c_str());
  return kAlgorithmFailed;
}

int RefineAndPrint(const RefineRunOptions& options) {
  const RefineRunSummary summary =
      RunRefinement(options, [](const std::string& line) { std::cerr << line << std::endl; });
  if (!summary.refinement.Succeeded()) {
    std::cerr << "refinement failed: " << ToString(summary.refinement.termination) << std::endl;
    return kAlgorithmFailed;
  }
  PrintOutcome(summary, options.output);
  return kDone;
}

void WriteAndPrintReport(const ReportOptions& options) {
  for (const ReportedMap& map : WriteReport(options)) {
    std::printf("%s: %zu of %zu surfels in the report\n", map.run.c_str(), map.shown_points,
                map.points);
  }
  std::printf("report: %s\n", options.output.c_str());
}

}  // namespace surfit::tools
