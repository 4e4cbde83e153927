#include "surfit/registration/register_clouds.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/median.h"
#include "registration/global/cloud_fit.h"
#include "registration/icp/cloud_covariance.h"
#include "registration/icp/icp_level.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/options.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

IcpOptions RegisterCloudsOptions::DefaultIcp() {
  IcpOptions icp;
  icp.association = "kd_tree";
  icp.kernel_growth = 3;
  return icp;
}

namespace {

int LevelStride(int source_count, int level) {
  return std::clamp(source_count / RegisterCloudsOptions::kMinPoints, 1, 1 << 2 * level);
}

void RegisterLevel(const SearchablePoints& source, const SearchablePoints& target, int level,
                   const Rigid3d& start, const RegisterCloudsOptions& options, IcpResult* result) {
  IcpOptions icp = options.icp;
  icp.gates.max_distance_m *= std::pow(icp.gate_growth, level);
  icp.error_model.kernel.width *= std::pow(icp.kernel_growth, level);
  icp.min_coarse_step_px = 0;  // clouds have no pixels
  const ResidualType residual = ResidualTypeFromName(icp.residual);
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(SolverOptions(icp, icp.error_model));
  const KdTreeAssociation association(
      source, target,
      {icp.gates, NormalsNeededBy(residual), options.reciprocal && level == 0,
       LevelStride(source.size(), level)});
  RunLevel({association, *solver, level, start}, icp, result);
}

void UpdateStatistics(const NormalSystem& system, int source_count, IcpResult* result) {
  result->system = system;
  result->inlier_count = system.inlier_count;
  result->inlier_ratio = static_cast<double>(system.inlier_count) / source_count;
  result->rmse_m = std::sqrt(system.AverageLoss());
}

// Moves the pose to the minimum of the cost and states its covariance. ICP ends if the RMSE changes
// little. Distances within the plane change so slowly that this pose can be several standard
// deviations from the minimum. Newton steps with the derivative of the covariance are faster,
// because this derivative contains the change of the correspondences.
void StateCovariance(const SearchablePoints& source_points, const SearchablePoints& target_points,
                     const PointSet& source, const PointSet& target,
                     const RegisterCloudsOptions& options, IcpResult* result) {
  constexpr int kMaxSteps = 5;
  constexpr double kLeastSigmas = 0.3;  // shorter steps add less than 2 % to the squared error
  const double spacing_m =
      std::max(MeasureScale(source.points).spacing_m, MeasureScale(target.points).spacing_m);
  const ResidualType residual = ResidualTypeFromName(options.icp.residual);
  const RobustKernel& kernel = options.icp.error_model.kernel;
  const KdTreeAssociation association(
      source_points, target_points,
      {options.icp.gates, NormalsNeededBy(residual), options.reciprocal, 1});
  const auto covariance_at = [&](const Rigid3d& pose) {
    return CovarianceOfClouds(association, pose, residual, kernel,
                              {MedianOf(source.sigma_m), kErrorSpacings * spacing_m});
  };
  CloudCovariance stated = covariance_at(result->target_from_source);
  for (int step = 0; step < kMaxSteps && stated.StepSigmas() > kLeastSigmas; ++step) {
    const Rigid3d pose = LeftIncrement<double>(stated.step_to_minimum, result->target_from_source);
    CloudCovariance next = covariance_at(pose);
    if (!next.covariance || next.StepSigmas() >= stated.StepSigmas()) break;
    stated = std::move(next);
    result->target_from_source = pose;
    ++result->step_count;
    UpdateStatistics(Linearize(association, pose, residual, kernel), source_points.size(), result);
  }
  result->covariance = stated.covariance;
  result->degenerate_directions = std::move(stated.degenerate_directions);
  if (!result->covariance) return;
  result->information = SymmetricInverse(*result->covariance);
}

}  // namespace

IcpResult RegisterClouds(const PointSet& source, const PointSet& target,
                         const Rigid3d& target_from_source_initial,
                         const RegisterCloudsOptions& options) {
  Validate(options);
  const SearchablePoints source_points(source), target_points(target);
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  for (int level = options.levels - 1; level >= 0; --level) {
    if (!options.icp.middle_levels && level > 0 && level < options.levels - 1) continue;
    RegisterLevel(source_points, target_points, level, target_from_source_initial, options,
                  &result);
    // Finer levels can constrain directions that are degenerate on a coarse level.
    if (result.termination == Termination::kTooFewInliers) return result;
  }
  if (result.Succeeded()) {
    StateCovariance(source_points, target_points, source, target, options, &result);
  }
  return result;
}

}  // namespace surfit
