#pragma once

#include "registration/icp/photometric_term.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

struct RowSums;

// The hand-built system of the pairs, on the source point as it is, for residuals weighted by the
// kernel. Single precision pairs: lanes of single precision, summed into double precision every few
// lanes. In a fixed order: the same at any number of threads.
template <typename S>
NormalSystem Linearize(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel);

// The same without what it has of products of rows (hessian, right_side, cost and
// weighted_square_sum), which stay 0: for SetProducts().
template <typename S>
NormalSystem BesidesProducts(const Pairs<S>& pairs, ResidualType residual,
                             const RobustKernel& kernel);
void SetProducts(const RowSums& sums, NormalSystem* system);
void SetProducts(const RowSums& sums, PhotometricSystem* system);

// The hand-built system of what an association finds at a pose, in one pass without a list of
// pairs.
NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel);

// That of intensities, weighted by the term's kernel; of given pairs, and of what the term finds.
PhotometricSystem Linearize(const IntensityPairs& pairs, const PhotometricTerm& term);
PhotometricSystem Linearize(const PhotometricTerm& term, const Rigid3d& target_from_source);

// The error model's kernel for a solve over these pairs, its width in estimated sigmas if so asked.
template <typename S>
RobustKernel KernelFor(const Pairs<S>& pairs, ResidualType residual, const ErrorModel& error_model);

// One resolution of a registration.
struct IcpLevel {
  const Association& association;
  const PoseSolver& solver;
  int level = 0;
  Rigid3d start;        // of the whole registration
  double focal_px = 0;  // turns a step into pixels, for min_coarse_step_px; 0 = not an image
};

// The options of a level's solver. Directions are free for it only where the eigenvalue is nothing
// but rounding: before convergence pairs are few, and normals differ by more than noise. With the
// pairs of a pose that is not yet the last, solves need not be finer than what ends a level.
PoseSolverOptions SolverOptions(const IcpOptions& options, const ErrorModel& error_model);

// Iterates from result->target_from_source until one of the terminations holds. On the finest level
// it then takes back what has moved, since the start, along directions that the data leaves free,
// and iterates along the others.
void RunLevel(const IcpLevel& level, const IcpOptions& options, IcpResult* result);

}  // namespace surfit
