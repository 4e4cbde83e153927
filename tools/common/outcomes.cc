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
      return Concat("inlier ratio is ", icp.inlier_ratio, ", required are at least min_inliers (",
                    options.min_inliers, ") correspondences and a ratio of ",
                    options.min_inlier_ratio);
    case Termination::kSingularSystem:
      return Concat("the surfaces do not constrain ", icp.degenerate_directions.size(),
                    " direction(s) of motion: smallest eigenvalue is ", icp.eigenvalues[0],
                    ", must be above min_eigenvalue (", options.observability.min_eigenvalue,
                    ") and min_information_ratio (", options.observability.min_information_ratio,
                    ") times the spurious information of normal noise");
    case Termination::kFreeSpaceViolation:
      return Concat("ratio of free-space violations is ", icp.free_space_violation_ratio,
                    ", must be at most max_free_space_violation_ratio (",
                    options.max_free_space_violation_ratio, ")");
    case Termination::kConverged:
    case Termination::kRmseIncreased:
    case Termination::kMaxIterations:
      break;
  }
  return "";
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

void WriteAndPrintReport(const ReportOptions& options) {
  for (const ReportedMap& map : WriteReport(options)) {
    std::printf("%s: %zu of %zu surfels in the report\n", map.run.c_str(), map.shown_points,
                map.points);
  }
  std::printf("report: %s\n", options.output.c_str());
}

}  // namespace surfit::tools
