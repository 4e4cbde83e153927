#include "surfit/registration/icp.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/named_values.h"
#include "registration/global/view_fit.h"
#include "registration/icp/icp_level.h"
#include "registration/icp/photometric_term.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr NamedValue<Termination> kRegistrationEnds[] = {
    {"converged", Termination::kConverged},
    {"rmse_increased", Termination::kRmseIncreased},
    {"max_iterations", Termination::kMaxIterations},
    {"too_few_inliers", Termination::kTooFewInliers},
    {"singular_system", Termination::kSingularSystem},
    {"free_space_violation", Termination::kFreeSpaceViolation}};

AssociationGates GatesOfLevel(const IcpOptions& options, int level) {
  AssociationGates gates = options.gates;
  gates.max_distance_m *= std::pow(options.gate_growth, level);
  return gates;
}

int RowStride(const IcpOptions& options, const FrameLevel& source) {
  if (options.min_source_rows == 0) return 1;
  return std::max(1, source.vertex.height() / options.min_source_rows);
}

// Photometric residuals use all image rows, because few points have texture. Geometric residuals
// use every row_stride-th row. The photometric weight is divided by the row stride to keep the
// balance of both.
ErrorModel ErrorModelOfLevel(const IcpOptions& options, int level, int row_stride) {
  ErrorModel error_model = options.error_model;
  error_model.photometric_weight /= row_stride;
  error_model.kernel.width *= std::pow(options.kernel_growth, level);
  return error_model;
}

std::unique_ptr<Association> MakeAssociation(const FrameLevel& source, const FrameLevel& target,
                                             const std::string& name, const AssociationGates& gates,
                                             const ErrorModel& error_model,
                                             NeededNormals needed_normals, int row_stride) {
  if (name == "projective") {
    return std::make_unique<ProjectiveAssociation>(source, target, gates, error_model,
                                                   needed_normals, row_stride);
  }
  return std::make_unique<KdTreeAssociation>(SearchablePoints(PointSetOf(source, error_model)),
                                             SearchablePoints(PointSetOf(target, error_model)),
                                             KdTreeAssociationOptions{gates, needed_normals});
}

void RegisterLevel(const FrameLevel& source, const FrameLevel& target, int level,
                   const Rigid3d& start, const IcpOptions& options, const PriorTerm* prior,
                   IcpResult* result) {
  const ResidualType residual = ResidualTypeFromName(options.residual);
  const int row_stride = RowStride(options, source);
  const ErrorModel error_model = ErrorModelOfLevel(options, level, row_stride);
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(SolverOptions(options, error_model));
  const AssociationGates gates = GatesOfLevel(options, level);
  std::optional<PhotometricTerm> photometric;
  if (error_model.UsesIntensities() && !source.intensity.empty() && !target.intensity.empty()) {
    photometric.emplace(source, target, gates.max_distance_m, error_model,
                        result->target_from_source);
    solver->Use(*photometric);
  }
  if (prior != nullptr) solver->Use(*prior);
  const std::unique_ptr<Association> association =
      MakeAssociation(source, target, options.association, gates, error_model,
                      NormalsNeededBy(residual), row_stride);
  RunLevel({*association, *solver, level, start, target.camera.fx, prior != nullptr}, options,
           result);
}

void CheckFreeSpace(const FrameLevel& source, const FrameLevel& target, const IcpOptions& options,
                    IcpResult* result) {
  if (options.max_free_space_violation_ratio >= 1) return;
  const Rigid3d& pose = result->target_from_source;
  result->free_space_violation_ratio =
      std::max(FreeSpaceViolationRatio(source, target, options.error_model, pose),
               FreeSpaceViolationRatio(target, source, options.error_model, pose.Inverse()));
  if (result->free_space_violation_ratio > options.max_free_space_violation_ratio) {
    result->termination = Termination::kFreeSpaceViolation;
  }
}

}  // namespace

std::string ToString(Termination termination) { return NameOf(termination, kRegistrationEnds); }

std::vector<std::string> AssociationNames() { return {"projective", "kd_tree"}; }

IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options) {
  Validate(options);
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  const int levels = static_cast<int>(std::min(source.levels.size(), target.levels.size()));
  for (int level = levels - 1; level >= 0; --level) {
    if (!options.middle_levels && level > 0 && level < levels - 1) continue;
    RegisterLevel(source.levels[level], target.levels[level], level, target_from_source_initial,
                  options, nullptr, &result);
    // A degenerate system does not end the registration. Finer levels can constrain directions that
    // are degenerate at a coarse level.
    if (result.termination == Termination::kTooFewInliers) return result;
  }
  if (levels > 0 && result.Succeeded())
    CheckFreeSpace(source.levels[0], target.levels[0], options, &result);
  return result;
}

IcpResult RegisterWithPrior(const FramePyramid& source, const FramePyramid& target,
                            const Rigid3d& target_from_source_initial, const PriorTerm& prior,
                            const IcpOptions& options) {
  Validate(options);
  ThrowIf(options.solver == "svd", "solver is 'svd', must be another one with a prior");
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  if (source.levels.empty() || target.levels.empty()) return result;
  RegisterLevel(source.levels[0], target.levels[0], 0, target_from_source_initial, options, &prior,
                &result);
  return result;
}

}  // namespace surfit
