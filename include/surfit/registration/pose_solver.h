#pragma once

#include <memory>
#include <string>
#include <vector>

#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

class PhotometricTerm;

// How the increment of a pose is computed.
struct PoseSolverOptions {
  std::string name = "closed_form_ldlt";   // one of PoseSolverNames()
  std::string linear_solver = "dense_qr";  // of ceres_per_point: one of LinearSolverNames()
  ResidualType residual = ResidualType::kPointToPlane;
  ErrorModel error_model;
  HeldOptions held;
  // Iterative solvers end where a step changes the cost by less than this share of it; 0 = by less
  // than the pairs' precision can tell.
  double min_relative_cost_change = 0;
};

// What a solve took, and what it went through.
struct SolveReport {
  double build_ms = 0;        // what Ceres is given
  double linearize_ms = 0;    // one linearisation; association included where both are done at once
  double solve_ms = 0;        // all but building
  std::vector<double> costs;  // what is minimised, at each linearisation, the first at the start
};

// One solve over given pairs.
struct StepResult {
  NormalSystem system;                    // the hand-built one, about the pose before the step
  Observability observability;            // of that system
  Vector6d increment = Vector6d::Zero();  // left increment (w [rad], v [m]) in the target frame,
                                          // with no part along free directions
  SolveReport report;
};

// Computes the increment of a pose from pairs of points. Where the data leaves directions free, the
// increment has no part along them.
class PoseSolver {
 public:
  explicit PoseSolver(const PoseSolverOptions& options) : options_(options) {}
  virtual ~PoseSolver() = default;

  // Makes steps from associations see the term's intensities as well. Keeps a reference.
  void Use(const PhotometricTerm& photometric) { photometric_ = &photometric; }

  // From what an association finds at a pose, in single precision.
  virtual StepResult Step(const Association& association,
                          const Rigid3d& target_from_source) const = 0;
  // From given pairs.
  virtual StepResult Step(const PairBuffer& pairs) const = 0;
  virtual StepResult Step(const Correspondences& pairs) const = 0;

  // Whether a step ends at the minimum of the robust cost over its pairs, rather than one
  // linearised step nearer.
  virtual bool ReachesMinimum() const { return false; }

  // The system at a pose and what it holds, without an increment.
  StepResult Describe(const Association& association, const Rigid3d& target_from_source) const;

 protected:
  const PoseSolverOptions& options() const { return options_; }
  const PhotometricTerm* photometric() const { return photometric_; }  // may be null

 private:
  PoseSolverOptions options_;
  const PhotometricTerm* photometric_ = nullptr;
};

// closed_form_ldlt, closed_form_lu, closed_form_qr: one Gauss-Newton step, the last from the matrix
// of all rows.
// svd: the rigid motion of the weighted points that is best in closed form; point_to_point only.
// ceres, ceres_per_point, tiny: Levenberg-Marquardt to the minimum of the robust cost over the
// given pairs, by Ceres on one reduced block of all pairs, by Ceres with a residual block for each
// pair (slow: the reference), and by Ceres' TinySolver on the reduced block.
std::vector<std::string> PoseSolverNames();

// dense_qr, dense_normal_cholesky, sparse_normal_cholesky (over SuiteSparse where Ceres has it).
std::vector<std::string> LinearSolverNames();

// Throws InputError that lists what is possible for unknown names and impossible combinations.
std::unique_ptr<PoseSolver> MakePoseSolver(const PoseSolverOptions& options);

}  // namespace surfit
