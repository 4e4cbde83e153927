#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

class OptionVisitor;

// How two surfaces are registered.
struct IcpOptions {
  std::string solver = "closed_form_ldlt";  // one of PoseSolverNames()
  std::string linear_solver = "dense_qr";   // of ceres_per_point: one of LinearSolverNames()
  std::string residual = "point_to_plane";  // one of ResidualTypeNames()
  std::string association = "projective";   // one of AssociationNames()
  bool middle_levels = true;                // false: only the coarsest and the finest level
  int max_iterations = 10;                  // on each level
  AssociationGates gates;                   // of the finest level
  double gate_growth = 2;                   // the distance gate grows by this on each coarser level
  double kernel_growth = 1;                 // and so does the robust kernel's width by this
  ErrorModel error_model;                   // of the finest level
  // On the finest level every n-th row of the source is used, but for its intensities, with the
  // largest n that leaves so many; 0 = all rows.
  int min_source_rows = 0;
  double min_coarse_step_px = 0;  // a coarser level also ends where points move by less of its px
  double min_relative_rmse_change = 1e-3;  // a level ends where RMSE changes by less ...
  double min_increment = 1e-5;             // ... or where rad and metres of the step are below
  bool stop_at_rmse_increase = true;       // or where it rises by more, and inliers do not
  int min_inliers = 200;          // pairs of whatever residual; half as many on each coarser level
  double min_inlier_share = 0.1;  // of the valid source points of the level
  HeldOptions held;               // what it takes for a direction to be held
  double max_free_space_share = 1;  // of IcpResult::free_space_share; 1 = off

  void Visit(OptionVisitor& visitor);
};

std::vector<std::string> AssociationNames();

enum class Termination {
  kConverged,        // the convergence rule held on the finest level
  kRmseIncreased,    // RMSE rose on the finest level, inliers did not: the pose is the one before
  kMaxIterations,    // the iterations of the finest level were used up
  kTooFewInliers,    // failure: fewer pairs than the options ask for
  kSingularSystem,   // failure: the data leaves directions free, along which the pose did not move
  kFreeSpaceFilled,  // failure: surfaces stand where the other view saw through
};

// "converged", "rmse_increased", "max_iterations", "too_few_inliers", "singular_system",
// "free_space_filled".
std::string ToString(Termination termination);

// The state of a level before a step or, its last one, after all steps.
struct IcpIteration {
  int level = 0;            // 0 is the finest
  double average_loss = 0;  // m^2, weighted mean of |r|^2
  double cost = 0;          // 1/2 sum of rho(s)
  int inlier_count = 0;     // pairs whose residual is within ErrorModel::kInlierSigmas
  SolveReport report;       // of the step; empty after all steps
};

// The outcome of a registration.
struct IcpResult {
  Termination termination = Termination::kTooFewInliers;
  Rigid3d target_from_source;
  std::vector<IcpIteration> iterations;
  int step_count = 0;  // over all levels
  // At that pose, on the level where ICP ended:
  int inlier_count = 0;     // pairs whose residual is within ErrorModel::kInlierSigmas
  double inlier_share = 0;  // of the valid source points
  double rmse_m = 0;        // square root of the weighted mean of |r|^2
  int intensity_count = 0;  // points whose intensities have a say: ErrorModel::photometric_weight
  Matrix6d information = Matrix6d::Zero();  // of the left increment (1/rad^2, 1/m^2), robust
  Matrix6d trusted_information = Matrix6d::Zero();  // see TrustedInformation()
  // The inverse of `information`, scaled by the residuals' variance in sigma^2, as if they were
  // independent; none where directions are free.
  std::optional<Matrix6d> covariance;
  Vector6d eigenvalues = Vector6d::Zero();  // of Observability: ascending, without unit
  // Left increments (rad, m) that the data does not hold, each of about a metre at the points.
  std::vector<Vector6d> free_directions;
  // The larger FreeSpaceShare() of source in target and target in source, on the finest level; 0
  // unless ICP came to its end there and the options limit it.
  double free_space_share = 0;

  // Otherwise the pose must not be used.
  bool Succeeded() const {
    return termination == Termination::kConverged || termination == Termination::kRmseIncreased ||
           termination == Termination::kMaxIterations;
  }
};

// Registers source to target, coarse to fine over the levels that both have, from an initial pose.
// ICP: find pairs, check, solve, move, repeat; each level starts at the best pose of the one
// before. Where ErrorModel::UsesIntensities() and both pyramids have intensities, these count as
// well, and what ends a level by its RMSE goes by NormalSystem::JointLoss() instead. Throws
// InputError for impossible options; failure to register is a termination, not an error.
IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options);

}  // namespace surfit
