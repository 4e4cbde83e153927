#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "registration/solvers/pair_solver.h"
#include "registration/solvers/reduced_cost.h"

namespace surfit {

// One block of the pairs, and one of intensities if there are any.
using ReducedBlocks = std::vector<std::unique_ptr<ReducedBlock>>;

// A solver that minimises over reduced blocks. What a StepResult tells of the products of rows is
// theirs at the start, so that these are summed once. Derived has
//   template <typename S>
//   Vector6d Minimum(ReducedBlocks blocks, const StepResult& before, SolveReport* report) const
// which gives the increment.
template <typename Derived>
class ReducedSolver : public PairSolver<Derived> {
 public:
  using PairSolver<Derived>::PairSolver;

  bool ReachesMinimum() const override { return true; }

  template <typename S>
  StepResult StepOver(Pairs<S> pairs, const IntensityPairs& intensities) const {
    const PoseSolverOptions& options = this->options();
    const RobustKernel kernel = KernelFor(pairs, options.residual, options.error_model);
    StepResult result;
    const Stopwatch besides;
    result.system = BesidesProducts(pairs, options.residual, kernel);
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
    result.report.costs = {result.system.JointCost()};
    result.observability = Observe(result.system, options.held);
    if (result.observability.free_count == 6) return result;
    const Stopwatch solving;
    result.increment = result.observability.Held(
        this->derived().template Minimum<S>(std::move(blocks), result, &result.report));
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
