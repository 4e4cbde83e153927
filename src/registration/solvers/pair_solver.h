#pragma once

#include <chrono>
#include <utility>

#include "registration/icp/icp_level.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// Base of solvers with one implementation for both precisions. Derived has
//   template <typename S>
//   Vector6d Solve(Pairs<S> pairs, const RobustKernel& kernel, const IntensityPairs& intensities,
//                  const Rigid3d* pose, const StepResult& before, SolveReport* report) const
// Solve() returns the increment. The arrays of `pairs` have exact size. If `intensities` is not
// empty, photometric() is not null. `pose` is the pose before the step if the step has a prior, and
// null without one. `before` contains the system and the observability.
template <typename Derived>
class PairSolver : public PoseSolver {
 public:
  using PoseSolver::PoseSolver;

  StepResult Step(const Association& association,
                  const Rigid3d& target_from_source) const override {
    const Stopwatch associating;
    IntensityPairs intensities;
    if (photometric() != nullptr) intensities = photometric()->Collect(target_from_source);
    PairBuffer pairs = association.Collect(target_from_source);
    const double associate_ms = associating.Milliseconds();
    StepResult result = derived().StepOver(std::move(pairs), intensities,
                                           prior() != nullptr ? &target_from_source : nullptr);
    result.report.linearize_ms += associate_ms;
    result.report.solve_ms += associate_ms;
    return result;
  }
  StepResult Step(const PairBuffer& pairs) const override {
    return derived().StepOver(pairs, {}, nullptr);
  }
  StepResult Step(const Correspondences& pairs) const override {
    return derived().StepOver(pairs, {}, nullptr);
  }

 protected:
  const Derived& derived() const { return static_cast<const Derived&>(*this); }

  // Step for given pairs. The increment is 0 if all directions are unobservable; Solve() is not
  // called then.
  template <typename S>
  StepResult StepOver(Pairs<S> pairs, const IntensityPairs& intensities,
                      const Rigid3d* pose) const {
    const RobustKernel& kernel = options().error_model.kernel;
    StepResult result;
    const Stopwatch linearizing;
    result.system = Linearize(pairs, options().residual, kernel);
    if (intensities.size > 0) result.system.Add(Linearize(intensities, *photometric()));
    result.report.linearize_ms = linearizing.Milliseconds();
    AddPriorCost(pose, &result);
    result.report.costs = {result.system.JointCost() + result.prior_cost};
    result.observability = Observe(result.system, options().observability);
    if (result.observability.degenerate_count == 6) return result;
    pairs.SetCapacity(pairs.size);
    result.increment =
        derived().Solve(std::move(pairs), kernel, intensities, pose, result, &result.report);
    if (pose == nullptr) result.increment = result.observability.Held(result.increment);
    return result;
  }

  void AddPriorCost(const Rigid3d* pose, StepResult* result) const {
    if (pose == nullptr) return;
    result->prior_cost = 0.5 * prior()->RowsAt(*pose).col(6).squaredNorm();
  }
};

// Factories of the pose solvers. Return null for names of other solvers. Throw InputError for
// invalid combinations.
std::unique_ptr<PoseSolver> MakeClosedFormSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeSvdSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeCeresSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeTinySolver(const PoseSolverOptions& options);

}  // namespace surfit
