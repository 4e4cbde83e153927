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

// Options of the registration of two surfaces.
struct IcpOptions {
  std::string solver = "closed_form_ldlt";  // a name of PoseSolverNames()
  std::string linear_solver = "dense_qr";   // for ceres_per_point: a name of LinearSolverNames()
  std::string residual = "point_to_plane";  // a name of ResidualTypeNames()
  std::string association = "projective";   // a name of AssociationNames()
  bool middle_levels = true;                // false: only the coarsest and the finest level
  int max_iterations = 10;                  // per level
  AssociationGates gates;                   // for the finest level
  double gate_growth = 2;                   // factor of the distance gate per coarser level
  double kernel_growth = 1;                 // factor of the robust kernel width per coarser level
  ErrorModel error_model;                   // for the finest level
  // Minimum number of source rows of a level; 0: all rows. Every n-th row is used, with
  // the largest possible n. Intensities use all rows, with 1 / n of their weight. kd_tree uses all
  // points.
  int min_source_rows = 0;
  double min_coarse_step_px = 0;  // coarser levels also end at smaller steps, px of the level
  double min_relative_rmse_change = 1e-3;  // a level ends at smaller relative changes of the RMSE
  double min_increment = 1e-5;             // a level ends at smaller steps, rad and m
  bool stop_at_rmse_increase = true;       // end a level if the RMSE rises without more inliers
  int min_inliers = 200;  // minimum of correspondences, halved per coarser level; at least 6
  double min_inlier_ratio = 0.1;       // minimum ratio of correspondences to valid source points
  ObservabilityOptions observability;  // thresholds for observable directions
  double max_free_space_violation_ratio = 1;  // IcpResult::free_space_violation_ratio; 1: no limit

  void Visit(OptionVisitor& visitor);
};

// "projective", "kd_tree".
std::vector<std::string> AssociationNames();

// End of a registration, see IcpResult::Succeeded().
enum class Termination {
  kConverged,           // convergence on the finest level
  kRmseIncreased,       // RMSE rose on the finest level: result is the pose before
  kMaxIterations,       // iteration limit on the finest level
  kTooFewInliers,       // failure: too few correspondences on a level; finer levels are not used
  kSingularSystem,      // failure: unobservable directions; the pose is not moved along them
  kFreeSpaceViolation,  // failure: too many free-space violations
};

// "converged", "rmse_increased", "max_iterations", "too_few_inliers", "singular_system",
// "free_space_violation".
std::string ToString(Termination termination);

// State of a level before a step, or after the last step of the level.
struct IcpIteration {
  int level = 0;            // 0: finest
  double average_loss = 0;  // weighted mean of |r|^2, m^2
  double cost = 0;          // 1/2 sum of rho(s), geometric
  int inlier_count = 0;     // residual within ErrorModel::kInlierSigmas
  SolveReport report;       // of the step from this state; empty without a step
};

// Result of a registration.
struct IcpResult {
  Termination termination = Termination::kTooFewInliers;
  Rigid3d target_from_source;
  std::vector<IcpIteration> iterations;
  int step_count = 0;  // sum of all levels
  // Statistics at the final pose, on the last level:
  int inlier_count = 0;                     // residual within ErrorModel::kInlierSigmas
  double inlier_ratio = 0;                  // inliers per valid source point
  double rmse_m = 0;                        // square root of the weighted mean of |r|^2
  int intensity_count = 0;                  // points with a photometric residual
  Matrix6d information = Matrix6d::Zero();  // of the left perturbation (1/rad^2, 1/m^2), robust
  Matrix6d trusted_information = Matrix6d::Zero();  // see ConservativeInformation()
  // Covariance (rad, m): the inverse of `information`, times the variance factor of the residuals.
  // Assumes independent residuals, so it is too small for images: see CovarianceOfViews().
  // RegisterClouds() states its own. std::nullopt if a direction is unobservable.
  std::optional<Matrix6d> covariance;
  NormalSystem system;  // for Observe() with other thresholds than those of the options
  Vector6d eigenvalues = Vector6d::Zero();  // of Observability: ascending, dimensionless
  // Observability::DegenerateDirections(): left perturbations (rad, m).
  std::vector<Vector6d> degenerate_directions;
  // Ratio of free-space violations on the finest level: the maximum of source in target and target
  // in source. 0 after an earlier failure, and for a max_free_space_violation_ratio of 1.
  double free_space_violation_ratio = 0;

  // If false, the pose is invalid.
  bool Succeeded() const {
    return termination == Termination::kConverged || termination == Termination::kRmseIncreased ||
           termination == Termination::kMaxIterations;
  }
};

// Registers source to target with ICP, coarse to fine over the levels that both have. Each level
// starts at the final pose of the level before. Photometric residuals require
// ErrorModel::UsesIntensities() and intensities in both pyramids. The convergence test then uses
// NormalSystem::JointLoss() instead of the RMSE. Motion along directions that are unobservable on
// the finest level by IcpOptions::observability is undone. Without a common level, the result is
// kTooFewInliers with the initial pose. Keeps no reference. Throws InputError for invalid options.
// With projective association, aborts if an image of the target differs in size from its camera. A
// failed registration is a termination, not an error.
IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options);

// Registers source to target on the finest level, with a prior of the pose in each step. The
// initial pose is a registration of both pyramids. The prior constrains all directions, so no
// motion is undone. Information and statistics of the result do not contain the prior. Throws
// InputError for invalid options, and for the solver svd, which has no prior.
IcpResult RegisterWithPrior(const FramePyramid& source, const FramePyramid& target,
                            const Rigid3d& target_from_source_initial, const PriorTerm& prior,
                            const IcpOptions& options);

// Covariance (rad, m) of the left perturbation of a registration by Register(), with the same views
// and options. It accounts for errors that neighbouring pixels share and for noise of normals:
// gradients of image blocks are the independent samples. It does not contain systematic errors of
// the sensor. The finest level with at most 400 columns represents all levels.
//
// std::nullopt if a direction is unobservable, for few correspondences, and for a failed
// registration. Also for projective point_to_point: both points of a correspondence are on one ray,
// so rotations do not change the residuals. Takes about as long as the registration.
std::optional<Matrix6d> CovarianceOfViews(const FramePyramid& source, const FramePyramid& target,
                                          const IcpResult& icp, const IcpOptions& options);

// Fast version of CovarianceOfViews() for tracking, with projective association. Uses the
// Gauss-Newton Hessian without NormalSystem::SpuriousInformation() instead of numerical
// derivatives, on the finest level with at most 200 columns. Requires common levels.
std::optional<Matrix6d> CovarianceByBlocks(const FramePyramid& source, const FramePyramid& target,
                                           const Rigid3d& target_from_source,
                                           const IcpOptions& options);

}  // namespace surfit
