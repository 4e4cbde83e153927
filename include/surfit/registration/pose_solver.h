#pragma once

#include <memory>
#include <string>
#include <vector>

#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

class PhotometricTerm;

// Weighted rows [A r] of a Gaussian prior: A is the Jacobian in the left perturbation (w [rad], v
// [m]), r is the residual in standard deviations.
using PriorRows = Eigen::Matrix<double, 6, 7>;

// Gaussian prior of a pose, in the units of the normal equations. Its residual is the error of
// cost_functions/pose_prior.h.
struct PriorTerm {
  Rigid3d target_from_source;
  Matrix6d information = Matrix6d::Zero();  // of the left perturbation, symmetric

  PriorRows RowsAt(const Rigid3d& pose) const;
};

// Options of the solver for a pose increment.
struct PoseSolverOptions {
  std::string name = "closed_form_ldlt";   // a name of PoseSolverNames()
  std::string linear_solver = "dense_qr";  // for ceres_per_point: a name of LinearSolverNames()
  ResidualType residual = ResidualType::kPointToPlane;
  ErrorModel error_model;
  ObservabilityOptions observability;
  // Iterative solvers stop if a step changes the cost by a smaller ratio. 0: the precision of the
  // correspondences.
  double min_relative_cost_change = 0;
};

// Times and costs of a solve.
struct SolveReport {
  double build_ms = 0;        // construction of the Ceres problem
  double linearize_ms = 0;    // data association, and one linearisation in the form of the solver
  double solve_ms = 0;        // everything except build_ms
  std::vector<double> costs;  // joint cost at each linearisation; costs[0]: before the step
};

// Result of one solver step.
struct StepResult {
  NormalSystem system;          // normal equations at the pose before the step, without the prior
  Observability observability;  // of `system`
  double prior_cost = 0;        // 1/2 |r|^2 of the prior at the pose before the step
  // Left perturbation (w [rad], v [m]) in the target frame. Without a prior, it is 0 along
  // unobservable directions.
  Vector6d increment = Vector6d::Zero();
  SolveReport report;
};

// Computes the increment of a pose from correspondences. The increment is 0 without
// correspondences. Without a prior, it is 0 along unobservable directions. Const functions change
// no state.
class PoseSolver {
 public:
  explicit PoseSolver(const PoseSolverOptions& options) : options_(options) {}
  virtual ~PoseSolver() = default;

  // Adds photometric residuals to steps with an Association. Stores a reference, which must be
  // valid during these steps.
  void Use(const PhotometricTerm& photometric) { photometric_ = &photometric; }

  // Adds a prior of the pose to steps with an Association. Its information must be positive
  // definite. Not for svd, which has no normal equations. Stores a reference, which must be valid
  // during these steps.
  void Use(const PriorTerm& prior) { prior_ = &prior; }

  // Finds correspondences at a pose in single precision, and computes a step.
  virtual StepResult Step(const Association& association,
                          const Rigid3d& target_from_source) const = 0;
  // Computes a step for given correspondences, without photometric residuals.
  virtual StepResult Step(const PairBuffer& pairs) const = 0;
  virtual StepResult Step(const Correspondences& pairs) const = 0;

  // True: a step minimises the robust cost for fixed correspondences. False: a step solves one
  // least-squares problem with constant weights.
  virtual bool ReachesMinimum() const { return false; }

  // System and observability at a pose, by the sums of Step(). The increment is 0.
  StepResult Describe(const Association& association, const Rigid3d& target_from_source) const;

 protected:
  const PoseSolverOptions& options() const { return options_; }
  const PhotometricTerm* photometric() const { return photometric_; }  // null: none
  const PriorTerm* prior() const { return prior_; }                    // null: none

 private:
  PoseSolverOptions options_;
  const PhotometricTerm* photometric_ = nullptr;
  const PriorTerm* prior_ = nullptr;
};

// Solver names:
// - closed_form_ldlt, closed_form_lu: one Gauss-Newton step from the normal equations.
// - closed_form_qr: one Gauss-Newton step from the matrix of all rows.
// - svd: optimal rigid motion for the kernel weights at the current pose; for point_to_point
//   without photometric residuals only.
// - ceres: Levenberg-Marquardt on the robust cost of fixed correspondences, as one reduced block.
// - ceres_per_point: as ceres, with one block per correspondence. Slow, the reference.
// - tiny: as ceres, with ceres::TinySolver.
std::vector<std::string> PoseSolverNames();

// dense_qr, dense_normal_cholesky, sparse_normal_cholesky (with SuiteSparse if Ceres has it).
std::vector<std::string> LinearSolverNames();

// Throws InputError for unknown names and invalid combinations. The message lists the valid values.
std::unique_ptr<PoseSolver> MakePoseSolver(const PoseSolverOptions& options);

}  // namespace surfit
