#pragma once

#include "registration/icp/photometric_term.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

struct RowSums;

// Normal equations of the pairs, with source points in the target frame and residuals weighted by
// the kernel. Single-precision pairs use single-precision lanes, which are added to
// double-precision sums every few lanes. The order is fixed, so the result does not depend on the
// number of threads.
template <typename S>
NormalSystem Linearize(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel);

// Normal system with hessian, right_side, cost and weighted_square_sum set to 0. SetProducts() adds
// these members.
template <typename S>
NormalSystem LinearizeWithoutProducts(const Pairs<S>& pairs, ResidualType residual,
                                      const RobustKernel& kernel);
// Adds the products of rows, and sets the cost.
void SetProducts(const RowSums& sums, NormalSystem* system);
void SetProducts(const RowSums& sums, PhotometricSystem* system);

// Normal equations of the pairs that an association finds at a pose. Single pass without a list of
// pairs.
NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel);

// Photometric normal equations, weighted by the kernel of the term.
PhotometricSystem Linearize(const IntensityPairs& pairs, const PhotometricTerm& term);
PhotometricSystem Linearize(const PhotometricTerm& term, const Rigid3d& target_from_source);

// Input of the registration on one pyramid level. Keeps references.
struct IcpLevel {
  const Association& association;
  const PoseSolver& solver;
  int level = 0;
  Rigid3d start;           // initial pose of the whole registration
  double focal_px = 0;     // px, for min_coarse_step_px; 0: not an image
  bool has_prior = false;  // the solver uses a prior: all directions are constrained
};

// Options of the pose solver of a level. During the iterations, only the rounding threshold of
// eigenvalues applies: correspondences are few, and their normals differ by more than noise. The
// convergence tolerance of iterative solvers follows from the tolerance of the level.
PoseSolverOptions SolverOptions(const IcpOptions& options, const ErrorModel& error_model);

// Iterates from result->target_from_source until termination, and extends `result`. On the finest
// level without a prior, the motion along degenerate directions is then undone, and the iterations
// continue along the constrained directions.
void RunLevel(const IcpLevel& level, const IcpOptions& options, IcpResult* result);

}  // namespace surfit
