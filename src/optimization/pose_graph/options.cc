#include "surfit/core/options.h"

#include <ceres/types.h>

#include "core/named_values.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {
namespace {

bool IsAvailable(ceres::SparseLinearAlgebraLibraryType type) {
  if (type == ceres::SUITE_SPARSE && !SURFIT_SUITESPARSE) return false;
  return ceres::IsSparseLinearAlgebraLibraryTypeAvailable(type);
}

}  // namespace

std::vector<std::string> SparseBackendNames() {
  std::vector<std::string> names;
  for (const auto& [name, type] : kSparseBackends) {
    if (IsAvailable(type)) names.emplace_back(name);
  }
  ThrowIf(names.empty(), "Ceres must be built with SuiteSparse or Eigen's solvers");
  return names;
}

std::vector<std::string> PoseGraphStartNames() { return NamesOf(kPoseGraphStarts); }

std::vector<std::string> LoopRobustnessNames() { return NamesOf(kLoopRobustness); }

std::vector<std::string> OdometryNames() { return NamesOf(kOdometryRules); }

std::string ToString(PoseGraphTermination termination) {
  return NameOf(termination, kTerminations);
}

void PoseGraphOptions::Visit(OptionVisitor& v) {
  v.Group("graph");
  v.Add(sparse_backend, "sparse_backend", "sparse linear solver of Ceres",
        OneOf(SparseBackendNames()), AsFlag("linear_solver"));
  v.Add(
      start, "start",
      "initial poses; given: from the file; odometry: chained along odometry edges; chordal: from "
      "all edges, by two linear systems",
      OneOf(PoseGraphStartNames()), AsFlag());
  v.Add(loop_robustness, "loop_robustness",
        "kernel of loop closures; gnc: truncated squared error; dcs, huber, cauchy, geman_mcclure: "
        "M-estimators; auto: best of several methods and starts",
        OneOf(LoopRobustnessNames()), AsFlag());
  v.Add(max_loop_squared_error, "max_loop_squared_error",
        "maximum error e^T information e of an inlier loop closure", Positive());
  v.Add(max_iterations, "max_iterations",
        "maximum number of Levenberg-Marquardt iterations, per round of gnc", AtLeast(1),
        AsFlag("max_graph_iterations"));
  v.Add(min_relative_cost_change, "min_relative_cost_change",
        "relative cost change below which iterations end", AtLeast(0));
  v.Add(max_round_iterations, "max_round_iterations",
        "maximum number of Levenberg-Marquardt iterations of a round of gnc before the final round",
        AtLeast(1));
  v.Add(min_round_cost_change, "min_round_cost_change",
        "relative cost change below which a round of gnc before the final round ends", AtLeast(0));
}

}  // namespace surfit
