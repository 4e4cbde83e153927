#include "surfit/registration/pose_solver.h"

#include "registration/solver_factories.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

std::string Listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

std::vector<std::string> PoseSolverNames() {
  return {
      "closed_form_ldlt", "closed_form_lu", "closed_form_qr", "ceres", "ceres_per_point", "tiny"};
}

std::unique_ptr<PoseSolver> MakePoseSolver(const PoseSolverOptions& options) {
  if (auto solver = MakeClosedFormSolver(options)) return solver;
  if (auto solver = MakeCeresSolver(options)) return solver;
  throw InputError(
      Concat("solver is '", options.name, "', must be one of: ", Listed(PoseSolverNames())));
}

}  // namespace surfit
