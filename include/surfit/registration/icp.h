#pragma once

#include <string>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/projective_association.h"

namespace surfit {

// How two surfaces are registered.
struct IcpOptions {
  std::string solver = "closed_form_ldlt";
  std::string linear_solver = "dense_qr";  // of ceres_per_point: see PoseSolverOptions
  std::string residual = "point_to_plane";
  std::string association = "projective";
  bool middle_levels = true;      // false: only the coarsest and the finest level
  int max_iterations = 10;        // on each level
  AssociationGates gates;         // of the finest level
  double gate_growth = 2;         // the distance gate grows by this on each coarser level
  double kernel_growth = 1;       // and so does the robust kernel's width by this
  ErrorModel error_model;         // of the finest level
  double min_coarse_step_px = 0;  // a coarser level also ends where points move by less of its px
  double min_relative_rmse_change = 1e-3;  // a level ends where RMSE changes by less ...
  double min_increment = 1e-5;             // ... or where rad and metres of the step are below
  int min_inliers = 200;                   // pairs, of whatever residual
  double min_inlier_share = 0.1;           // of the valid source points of the level
  double min_eigenvalue = 1e-6;            // scaled; below it the problem is singular
  double max_free_space_share = 1;         // of IcpResult::free_space_share; 1 = off

  // Throws InputError naming field, value and constraint.
  void Validate() const;
};

enum class Termination {
  kConverged,        // the convergence rule held on the finest level
  kMaxIterations,    // the iterations of the finest level were used up
  kTooFewInliers,    // failure: fewer pairs than the options ask for
  kSingularSystem,   // failure: the data does not hold some direction
  kFreeSpaceFilled,  // failure: surfaces stand where the other view saw through
};

// "converged", "max_iterations", "too_few_inliers", "singular_system",
// "free_space_filled".
std::string ToString(Termination termination);

// The state of a level before a step or, its last one, after all steps.
struct IcpIteration {
  int level = 0;            // 0 is the finest
  double average_loss = 0;  // m^2, weighted mean of r^2
  int inlier_count = 0;     // pairs whose residual is within ErrorModel::kInlierSigmas
};

// The outcome of a registration.
struct IcpResult {
  Termination termination = Termination::kTooFewInliers;
  Rigid3d target_from_source;  // the last pose reached
  std::vector<IcpIteration> iterations;
  int step_count = 0;  // over all levels
  // At that pose, on the level where ICP ended:
  int inlier_count = 0;                 // pairs whose residual is within ErrorModel::kInlierSigmas
  double inlier_share = 0;              // of the valid source points
  double rmse_m = 0;                    // square root of the weighted mean of r^2
  Matrix6d hessian = Matrix6d::Zero();  // information of the left increment (1/rad^2, 1/m^2)
  double smallest_eigenvalue = 0;       // of NormalSystem::ScaledEigenvalues()
  // The larger FreeSpaceShare() of source in target and target in source, on the finest level; 0
  // unless ICP came to its end there and the options limit it.
  double free_space_share = 0;

  // Converged or out of iterations; otherwise the pose must not be used.
  bool Succeeded() const {
    return termination == Termination::kConverged || termination == Termination::kMaxIterations;
  }
};

// Registers source to target, coarse to fine over the levels that both have, from an initial pose.
// Point-to-plane ICP (Chen and Medioni 1992) with Gauss-Newton steps as the options choose.
// Throws InputError for impossible options; failure to register is a termination, not an error.
IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options);

}  // namespace surfit
