#include <ceres/types.h>

#include <cmath>

#include "core/named_values.h"
#include "optimization/pose_graph_names.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {
namespace {

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
}

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
  if (names.empty()) throw InputError("Ceres must be built with SuiteSparse or Eigen's solvers");
  return names;
}

std::vector<std::string> PoseGraphInitializationNames() { return NamesOf(kInitializations); }

std::vector<std::string> LoopRobustnessNames() { return NamesOf(kLoopRobustness); }

std::string ToString(PoseGraphTermination termination) {
  return NameOf(termination, kTerminations);
}

void PoseGraphOptions::Validate() const {
  RequireName("sparse_backend", sparse_backend, SparseBackendNames());
  RequireName("initialization", initialization, PoseGraphInitializationNames());
  RequireName("loop_robustness", loop_robustness, LoopRobustnessNames());
  Require(std::isfinite(max_loop_squared_error) && max_loop_squared_error > 0,
          "max_loop_squared_error", max_loop_squared_error, "finite and positive");
  Require(max_iterations >= 1, "max_iterations", max_iterations, "at least 1");
  Require(std::isfinite(min_relative_cost_change) && min_relative_cost_change >= 0,
          "min_relative_cost_change", min_relative_cost_change, "finite and zero or positive");
}

}  // namespace surfit
