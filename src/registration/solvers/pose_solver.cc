#include "surfit/registration/pose_solver.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/named_values.h"
#include "cost_functions/analytic_relative_pose.h"
#include "cost_functions/pose_error.h"
#include "registration/icp/own_residuals.h"
#include "registration/solvers/pair_solver.h"

namespace surfit {

namespace {

// Entry i is the ResidualType with the value i.
constexpr NamedValue<ResidualType> kTypes[] = {
    {"point_to_point", ResidualType::kPointToPoint},
    {"point_to_plane", ResidualType::kPointToPlane},
    {"symmetric_point_to_plane", ResidualType::kSymmetricPointToPlane},
    {"plane_to_plane", ResidualType::kPlaneToPlane}};

struct NamedResidual {
  std::string name;
  std::unique_ptr<const OwnResidual> residual;
};

// User-defined residuals. Their types follow the built-in types.
std::vector<NamedResidual>& OwnResiduals() {
  static std::vector<NamedResidual> residuals;
  return residuals;
}

constexpr int kFirstOwn = static_cast<int>(std::size(kTypes));

const NamedResidual* Own(ResidualType type) {
  const int i = static_cast<int>(type) - kFirstOwn;
  return i >= 0 ? &OwnResiduals().at(i) : nullptr;
}

}  // namespace

void RegisterResidual(const std::string& name, std::unique_ptr<const OwnResidual> residual) {
  const std::vector<std::string> names = ResidualTypeNames();
  if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) {
    throw InputError("name of a residual is '", name,
                     "', must not be empty and must be none of: ", JoinNames(names));
  }
  OwnResiduals().push_back({name, std::move(residual)});
}

const OwnResidual* OwnResidualOf(ResidualType type) {
  const NamedResidual* const own = Own(type);
  return own != nullptr ? own->residual.get() : nullptr;
}

std::vector<std::string> ResidualTypeNames() {
  std::vector<std::string> names = NamesOf(kTypes);
  for (const NamedResidual& own : OwnResiduals()) names.push_back(own.name);
  return names;
}

ResidualType ResidualTypeFromName(const std::string& name) {
  const std::vector<std::string> names = ResidualTypeNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<ResidualType>(found - names.begin());
  throw InputError("residual is '", name, "', must be one of: ", JoinNames(names));
}

std::string ToString(ResidualType type) {
  return ResidualTypeNames().at(static_cast<std::size_t>(type));
}

NeededNormals NormalsNeededBy(ResidualType type) {
  if (const OwnResidual* const own = OwnResidualOf(type)) return own->needed_normals();
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

// The error E = X Z^-1 of pose X and prior Z becomes exp(w) E with the translation exp(w) e + v. To
// first order, this adds J w to log E_R, and w x e + v to e. J is the inverse left Jacobian.
PriorRows PriorTerm::RowsAt(const Rigid3d& pose) const {
  const Vector6d error = FirstOrderIncrement(target_from_source, pose);
  PriorRows rows = PriorRows::Zero();
  rows.block<3, 3>(0, 0) = InverseLeftJacobian(error.head<3>());
  rows.block<3, 3>(3, 0) = -CrossMatrix<double>(error.tail<3>());
  rows.block<3, 3>(3, 3).setIdentity();
  rows.col(6) = error;
  return InformationRoot(information) * rows;
}

StepResult PoseSolver::Describe(const Association& association,
                                const Rigid3d& target_from_source) const {
  StepResult result;
  result.system =
      Linearize(association, target_from_source, options_.residual, options_.error_model.kernel);
  if (photometric_ != nullptr) result.system.Add(Linearize(*photometric_, target_from_source));
  if (prior_ != nullptr) {
    result.prior_cost = 0.5 * prior_->RowsAt(target_from_source).col(6).squaredNorm();
  }
  result.observability = Observe(result.system, options_.observability);
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
  throw InputError("solver is '", options.name,
                   "', must be one of: ", JoinNames(PoseSolverNames()));
}

}  // namespace surfit
