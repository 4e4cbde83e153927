#include <algorithm>

#include "apps/solvers/pose_problem.h"
#include "core/named_values.h"
#include "surfit/core/error.h"
#include "surfit/optimization/refine.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

constexpr char kPerPoint[] = "ceres_per_point";

// Throws InputError for unknown names.
std::vector<std::string> Chosen(const char* option, const std::vector<std::string>& named,
                                const std::vector<std::string>& all) {
  for (const std::string& name : named) {
    if (std::find(all.begin(), all.end(), name) != all.end()) continue;
    throw InputError(option, " contains '", name, "', must be one of: ", JoinNames(all));
  }
  return named.empty() ? all : named;
}

std::vector<SolverCombination> OfRefinement(const CompareOptions& options) {
  std::vector<SolverCombination> combinations;
  for (const std::string& residual :
       Chosen("residuals", options.residuals, {kPlaneResidual, kTexturedResidual})) {
    for (const std::string& solver : Chosen("solvers", options.solvers, RefinementSolverNames())) {
      if (solver == "reduced") {
        combinations.push_back({solver, "", residual, kKnownAssociation});
        continue;
      }
      for (const std::string& linear_solver :
           Chosen("linear_solvers", options.linear_solvers, RefinementLinearSolverNames())) {
        combinations.push_back({solver, linear_solver, residual, kKnownAssociation});
      }
    }
  }
  return combinations;
}

std::vector<std::string> ChosenSolvers(const CompareOptions& options) {
  std::vector<std::string> solvers = Chosen("solvers", options.solvers, PoseSolverNames());
  if (options.solvers.empty() && options.synthetic_points == 0) {
    solvers.erase(std::remove(solvers.begin(), solvers.end(), kPerPoint), solvers.end());
  }
  return solvers;
}

std::vector<std::string> ChosenAssociations(const CompareOptions& options) {
  if (options.synthetic_points > 0) {
    if (options.associations.empty()) return {kKnownAssociation};
    throw InputError("associations is ", JoinNames(options.associations),
                     ", must be empty with synthetic_points, whose correspondences are known");
  }
  const bool clouds = !options.source.empty();
  return Chosen("associations", options.associations,
                clouds ? std::vector<std::string>{"kd_tree"} : AssociationNames());
}

bool IsPossible(const std::string& solver, const std::string& residual) {
  return solver != "svd" || residual == "point_to_point";
}

void RequirePossible(const std::string& solver, const std::string& residual) {
  if (IsPossible(solver, residual)) return;
  throw InputError("solvers contains 'svd' and residuals contains '", residual,
                   "', which are incompatible: svd supports point_to_point only, ",
                   "all other solvers support ", JoinNames(ResidualTypeNames()));
}

}  // namespace

std::string SolverCombination::SolverTitle() const {
  return linear_solver.empty() ? solver : solver + " (" + linear_solver + ")";
}

bool IsSlow(const SolverCombination& combination) { return combination.solver == kPerPoint; }

std::vector<SolverCombination> SolverCombinations(const CompareOptions& options) {
  if (!options.run.empty()) return OfRefinement(options);
  const std::vector<std::string> solvers = ChosenSolvers(options);
  const std::vector<std::string> linear_solvers =
      Chosen("linear_solvers", options.linear_solvers, LinearSolverNames());
  const std::vector<std::string> residuals =
      Chosen("residuals", options.residuals, ResidualTypeNames());
  const std::vector<std::string> associations = ChosenAssociations(options);
  const bool both_named = !options.solvers.empty() && !options.residuals.empty();
  std::vector<SolverCombination> combinations;
  for (const std::string& association : associations) {
    for (const std::string& residual : residuals) {
      for (const std::string& solver : solvers) {
        if (both_named) RequirePossible(solver, residual);
        if (!IsPossible(solver, residual)) continue;
        if (solver != kPerPoint) {
          combinations.push_back({solver, "", residual, association});
          continue;
        }
        for (const std::string& linear_solver : linear_solvers) {
          combinations.push_back({solver, linear_solver, residual, association});
        }
      }
    }
  }
  if (combinations.empty()) {  // svd needs point_to_point
    RequirePossible(solvers.front(), residuals.front());
  }
  return combinations;
}

}  // namespace surfit
