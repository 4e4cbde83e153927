#include "surfit/registration/pose_solver.h"

#include "core/named_values.h"
#include "registration/pair_solver.h"
#include "surfit/registration/error_model.h"

namespace surfit {

namespace {

constexpr NamedValue<ResidualType> kTypes[] = {
    {"point_to_point", ResidualType::kPointToPoint},
    {"point_to_plane", ResidualType::kPointToPlane},
    {"symmetric_point_to_plane", ResidualType::kSymmetricPointToPlane},
    {"plane_to_plane", ResidualType::kPlaneToPlane}};

}  // namespace

std::vector<std::string> ResidualTypeNames() { return NamesOf(kTypes); }

ResidualType ResidualTypeFromName(const std::string& name) {
  return ValueOf("residual", name, kTypes);
}

std::string ToString(ResidualType type) { return NameOf(type, kTypes); }

NeededNormals NormalsNeededBy(ResidualType type) {
  switch (type) {
    case ResidualType::kPointToPoint:
      return NeededNormals::kNone;
    case ResidualType::kPointToPlane:
      return NeededNormals::kTarget;
    case ResidualType::kSymmetricPointToPlane:
    case ResidualType::kPlaneToPlane:
      break;
  }
  return NeededNormals::kBoth;
}

StepResult PoseSolver::Describe(const Association& association,
                                const Rigid3d& target_from_source) const {
  const ErrorModel& error_model = options_.error_model;
  StepResult result;
  if (error_model.estimate_scale) {
    const PairBuffer pairs = association.Collect(target_from_source);
    result.system =
        Linearize(pairs, options_.residual, KernelFor(pairs, options_.residual, error_model));
  } else {
    result.system =
        Linearize(association, target_from_source, options_.residual, error_model.kernel);
  }
  if (photometric_ != nullptr) result.system.Add(Linearize(*photometric_, target_from_source));
  result.observability = Observe(result.system, options_.held);
  return result;
}

std::vector<std::string> PoseSolverNames() {
  return {"closed_form_ldlt",
          "closed_form_lu",
          "closed_form_qr",
          "svd",
          "ceres",
          "ceres_per_point",
          "tiny"};
}

std::unique_ptr<PoseSolver> MakePoseSolver(const PoseSolverOptions& options) {
  for (const auto make : {MakeClosedFormSolver, MakeSvdSolver, MakeCeresSolver, MakeTinySolver}) {
    if (auto solver = make(options)) return solver;
  }
  throw InputError(
      Concat("solver is '", options.name, "', must be one of: ", Listed(PoseSolverNames())));
}

}  // namespace surfit
