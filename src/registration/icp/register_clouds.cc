#include "surfit/registration/register_clouds.h"

#include <cmath>
#include <memory>

#include "registration/icp/icp_level.h"
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

// Coarsest level with at least kMinPoints source points.
int CoarsestLevel(int source_count, int levels) {
  int level = levels - 1;
  while (level > 0 && source_count >> 2 * level < RegisterCloudsOptions::kMinPoints) --level;
  return level;
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
      {icp.gates, NormalsNeededBy(residual), options.reciprocal && level == 0, 1 << 2 * level});
  RunLevel({association, *solver, level, start}, icp, result);
}

}  // namespace

IcpResult RegisterClouds(const PointSet& source, const PointSet& target,
                         const Rigid3d& target_from_source_initial,
                         const RegisterCloudsOptions& options) {
  Validate(options);
  const SearchablePoints source_points(source), target_points(target);
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  const int coarsest = CoarsestLevel(source_points.size(), options.levels);
  for (int level = coarsest; level >= 0; --level) {
    if (!options.icp.middle_levels && level > 0 && level < coarsest) continue;
    RegisterLevel(source_points, target_points, level, target_from_source_initial, options,
                  &result);
    // Finer levels can constrain directions that are degenerate on a coarse level.
    if (result.termination == Termination::kTooFewInliers) return result;
  }
  return result;
}

}  // namespace surfit
