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

// Computes the increment of a pose from associated surfaces.
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

// closed_form_ldlt, closed_form_lu, closed_form_qr.
std::vector<std::string> PoseSolverNames();

// The solver of that name; throws InputError that lists the known ones for an unknown name.
std::unique_ptr<PoseSolver> MakePoseSolver(const std::string& name, double min_eigenvalue);

}  // namespace surfit
