#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/reduced_batch.h"
#include "registration/icp/photometric_term.h"
#include "registration/solvers/pair_solver.h"

namespace surfit {

// All pairs as one ReducedBatch of the residual's functor, in the precision of the pairs. The
// arrays of `pairs` must have exactly `pairs.size` elements. The pose block starts at the identity,
// see functor_batch.h.
template <typename S>
std::unique_ptr<ReducedBlock> MakeReducedCost(Pairs<S> pairs, ResidualType residual,
                                              const RobustKernel& kernel);

std::unique_ptr<ReducedBlock> MakeReducedCost(const IntensityPairs& pairs,
                                              const PhotometricTerm& term);

// Cost of a prior over the left increment from `pose`. The last of kRowColumns residuals is 0.
std::unique_ptr<ceres::CostFunction> MakePriorCost(const PriorTerm& prior, const Rigid3d& pose);

using PoseBlock = std::array<double, kPoseSize>;

inline PoseBlock IdentityBlock() { return {0, 0, 0, 1, 0, 0, 0}; }

// Left increment from the identity to a pose.
inline Vector6d AsIncrement(const PoseBlock& pose) {
  Vector6d increment;
  LeftPoseManifold().Minus(pose.data(), IdentityBlock().data(), increment.data());
  return increment;
}

// Tolerances of Levenberg-Marquardt. Single precision: rounding of the sums, too small to affect
// the association. Double precision: rounding of the cost.
template <typename S>
struct LmTolerances {
  static constexpr bool kSingle = sizeof(S) == sizeof(float);
  static constexpr double kFunction = kSingle ? 1e-9 : 1e-16;
  static constexpr double kGradient = kSingle ? 1e-10 : 1e-14;
  static constexpr double kParameter = kSingle ? 1e-8 : 1e-13;
  static constexpr int kMaxIterations = 50;
};

// One block of the pairs, and one of the photometric residuals if there are any.
using ReducedBlocks = std::vector<std::unique_ptr<ReducedBlock>>;

// Base of solvers that minimise over reduced blocks. The normal equations of the StepResult come
// from the blocks, so they are summed only once. Derived has
//   template <typename S>
//   Vector6d Minimum(ReducedBlocks blocks, std::unique_ptr<ceres::CostFunction> prior,
//                    const StepResult& before, SolveReport* report) const
// Minimum() returns the increment. `prior` is null without a prior.
template <typename Derived>
class ReducedSolver : public PairSolver<Derived> {
 public:
  using PairSolver<Derived>::PairSolver;

  bool ReachesMinimum() const override { return true; }

  template <typename S>
  StepResult StepOver(Pairs<S> pairs, const IntensityPairs& intensities,
                      const Rigid3d* pose) const {
    const PoseSolverOptions& options = this->options();
    const RobustKernel& kernel = options.error_model.kernel;
    StepResult result;
    const Stopwatch besides;
    result.system = LinearizeWithoutProducts(pairs, options.residual, kernel);
    double linearize_ms = besides.Milliseconds();
    const Stopwatch building;
    ReducedBlocks blocks;
    pairs.SetCapacity(pairs.size);
    blocks.push_back(MakeReducedCost(std::move(pairs), options.residual, kernel));
    if (intensities.size > 0) blocks.push_back(MakeReducedCost(intensities, *this->photometric()));
    result.report.build_ms = building.Milliseconds();
    const Stopwatch linearizing;
    AddProducts(blocks, intensities.size, &result.system);
    linearize_ms += linearizing.Milliseconds();
    result.report.linearize_ms = result.report.solve_ms = linearize_ms;
    this->AddPriorCost(pose, &result);
    result.report.costs = {result.system.JointCost() + result.prior_cost};
    result.observability = Observe(result.system, options.observability);
    if (result.observability.degenerate_count == 6) return result;
    const Stopwatch solving;
    result.increment = this->derived().template Minimum<S>(
        std::move(blocks), pose != nullptr ? MakePriorCost(*this->prior(), *pose) : nullptr, result,
        &result.report);
    if (pose == nullptr) result.increment = result.observability.Held(result.increment);
    result.report.linearize_ms = linearize_ms;
    result.report.solve_ms = linearize_ms + solving.Milliseconds();
    return result;
  }

 private:
  static void AddProducts(const ReducedBlocks& blocks, int intensity_count, NormalSystem* system) {
    SetProducts(blocks[0]->Prepare(), system);
    if (blocks.size() == 1) return;
    PhotometricSystem of_intensities;
    SetProducts(blocks[1]->Prepare(), &of_intensities);
    of_intensities.row_count = intensity_count;
    system->Add(of_intensities);
  }
};

}  // namespace surfit
