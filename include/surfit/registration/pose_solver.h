#pragma once

#include <memory>
#include <string>
#include <vector>

#include "surfit/registration/projective_association.h"

namespace surfit {

// One Gauss-Newton step.
struct StepResult {
  // The smallest scaled eigenvalue is too small: the data does not hold some direction. There is
  // then no increment.
  bool singular = false;
  Vector6d increment = Vector6d::Zero();  // left increment (w [rad], v [m]) in the target frame
  NormalSystem system;                    // what was solved, about the pose before the step
  double smallest_eigenvalue = 0;         // of NormalSystem::ScaledEigenvalues()
};

// Computes the increment of a pose from associated surfaces, whose pairs it keeps.
class PoseSolver {
 public:
  virtual ~PoseSolver() = default;
  virtual StepResult Step(const ProjectiveAssociation& association,
                          const Rigid3d& target_from_source) const = 0;
};

// The closed-form solvers on given correspondences; `min_eigenvalue` is the border of `singular`.
StepResult SolveLdlt(const NormalSystem& system, double min_eigenvalue);
StepResult SolveLu(const NormalSystem& system, double min_eigenvalue);
// Householder QR of the N x 6 matrix with rows sqrt(w) a: the condition number is not squared.
StepResult SolveQr(const Correspondences& correspondences, double min_eigenvalue);

// What makes one solver out of the others.
struct PoseSolverOptions {
  std::string name = "closed_form_ldlt";   // one of PoseSolverNames()
  std::string linear_solver = "dense_qr";  // of ceres_per_point: one of LinearSolverNames()
  double min_eigenvalue = 1e-6;            // scaled; below it the problem is singular
};

// closed_form_ldlt, closed_form_lu, closed_form_qr: one Gauss-Newton step.
// ceres, ceres_per_point, tiny: Levenberg-Marquardt to the minimum of the robust cost over the
// given pairs, by Ceres on one reduced block of all pairs, by Ceres with a residual block for each
// pair (slow: the reference), and by Ceres' TinySolver on the reduced block.
std::vector<std::string> PoseSolverNames();

// dense_qr, dense_normal_cholesky, sparse_normal_cholesky (over SuiteSparse where Ceres has it).
std::vector<std::string> LinearSolverNames();

// Throws InputError that lists the known names for an unknown one.
std::unique_ptr<PoseSolver> MakePoseSolver(const PoseSolverOptions& options);

}  // namespace surfit
