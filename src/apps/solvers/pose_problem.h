#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/solvers/compare_solvers.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

inline constexpr char kKnownAssociation[] = "known";
// Of joint refinement.
inline constexpr char kPlaneResidual[] = "planes";
inline constexpr char kTexturedResidual[] = "planes_and_textures";

// The combinations that the options ask for, residual by residual. Throws InputError that lists
// what is possible for unknown names, and for solvers and residuals that were both named and do not
// go together.
std::vector<SolverCombination> SolverCombinations(const CompareOptions& options);

// Whether a combination is so slow that it runs on little.
bool IsSlow(const SolverCombination& combination);

// A place in the grid of perturbations.
struct GridCell {
  int rotation = 0;  // indices of what is perturbed by
  int translation = 0;
  bool on_diagonal() const { return rotation == translation; }
  friend bool operator==(const GridCell& a, const GridCell& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

// All cells, rotation by rotation.
std::vector<GridCell> AllCells(int rotations, int translations);

// The pose turned about the target's origin by an angle and shifted by a distance, about and along
// axes that are random and depend on the seed alone.
Rigid3d Perturbed(const Rigid3d& target_from_source, double rotation_rad, double translation_m,
                  std::uint64_t seed);

// What one combination made of one start.
struct SolveOutcome {
  Rigid3d target_from_source;
  std::string termination;  // empty over known pairs
  bool succeeded = false;
  int points = 0;
  int iterations = 0;
  std::optional<double> build_ms, linearize_ms, solve_ms;  // medians of the finest level's solves
  double total_ms = 0;
  double final_cost = 0;
  std::vector<double> losses;  // m^2, weighted mean of |r|^2 at each iteration; of refinement costs
  std::optional<double> iteration_ms, memory_bytes;  // of refinement: ComparisonRow
};

// Two surfaces, and how to solve for the motion between them.
struct PoseProblem {
  std::optional<Rigid3d> truth;  // target_from_source
  Rigid3d center;                // what starts are perturbations of
  std::function<SolveOutcome(const SolverCombination&, const Rigid3d& start)> solve;
};

// Problems, each made when it is its turn.
struct PoseProblems {
  int count = 0;
  std::function<PoseProblem(int)> make;
};

// Of the options' synthetic_points, sequence, clouds, replay, or run.
PoseProblems KnownPairsProblems(const CompareOptions& options);
PoseProblems FramePairProblems(const CompareOptions& options);
PoseProblems CloudProblems(const CompareOptions& options);
PoseProblems ReplayProblems(const CompareOptions& options);
PoseProblems RefinementProblems(const CompareOptions& options);  // starts are all alike

// Two frames.
PoseProblem FramePairProblem(FramePyramid source, FramePyramid target,
                             const std::optional<Rigid3d>& truth, const Rigid3d& center,
                             const IcpOptions& icp);

// Makes the options those of a combination.
void SetCombination(const SolverCombination& combination, IcpOptions* icp);

// Sets the times from what the solves of one start took.
void SetTimes(const std::vector<SolveReport>& reports, SolveOutcome* outcome);

// A registration by ICP, taken from its result and the time it took.
SolveOutcome OutcomeOf(const IcpResult& result, int points, double total_ms);

}  // namespace surfit
