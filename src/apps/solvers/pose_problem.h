#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/solvers/compare_solvers.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Names of associations and residuals that only this comparison has.
inline constexpr char kKnownAssociation[] = "known";
inline constexpr char kPlaneResidual[] = "planes";
inline constexpr char kTexturedResidual[] = "planes_and_textures";

// Selected combinations, ordered by association and residual. Throws InputError for unknown names,
// and if a named solver does not support a named residual, or if no combination remains. Other
// unsupported combinations are omitted.
std::vector<SolverCombination> SolverCombinations(const CompareOptions& options);

// Returns whether a combination is slow and runs on few problems only.
bool IsSlow(const SolverCombination& combination);

// Combination of a rotation and a translation of the initial pose.
struct PerturbationCell {
  int rotation = 0;  // indices into rotations_deg and translations_m
  int translation = 0;
  bool on_diagonal() const { return rotation == translation; }
  friend bool operator==(const PerturbationCell& a, const PerturbationCell& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

// All pairs of indices, ordered by the rotation.
std::vector<PerturbationCell> AllCells(int rotations, int translations);

// Perturbed pose: rotation about the origin of the target, then translation. Random axes, which
// depend on `seed` only. Axes of rotation and translation are independent.
Rigid3d Perturbed(const Rigid3d& target_from_source, double rotation_rad, double translation_m,
                  std::uint64_t seed);

struct SolveOutcome {
  Rigid3d target_from_source;
  std::string termination;
  bool succeeded = false;
  int points = 0;
  int iterations = 0;
  std::optional<double> build_ms, linearize_ms, solve_ms;  // medians on the finest level
  double total_ms = 0;
  double final_cost = 0;       // 1/2 sum of rho(s)
  std::vector<double> losses;  // per iteration: weighted mean of |r|^2, m^2; refinement: cost
  std::optional<double> iteration_ms, memory_bytes;  // refinement only, see ComparisonRow
};

// Problem to solve from perturbed initial poses.
struct PoseProblem {
  std::optional<Rigid3d> truth;  // target_from_source
  Rigid3d center;                // unperturbed initial pose
  std::function<SolveOutcome(const SolverCombination&, const Rigid3d& start)> solve;
};

// Problems 0 to count - 1. make() may read files, and throws InputError.
struct PoseProblems {
  int count = 0;
  std::function<PoseProblem(int)> make;
};

// Problems for synthetic_points, sequence, source and target, replay, and run. Keep a reference to
// the options. Throw InputError for unreadable data.
PoseProblems KnownPairsProblems(const CompareOptions& options);
PoseProblems FramePairProblems(const CompareOptions& options);
PoseProblems CloudProblems(const CompareOptions& options);
PoseProblems ReplayProblems(const CompareOptions& options);
PoseProblems RefinementProblems(const CompareOptions& options);  // all initial poses are equal

// Registration of two frames from `center`. `icp`: options except those of the combination.
PoseProblem FramePairProblem(FramePyramid source, FramePyramid target,
                             const std::optional<Rigid3d>& truth, const Rigid3d& center,
                             const IcpOptions& icp);

// Sets solver, residual and association, and the linear solver if it is named.
void SetCombination(const SolverCombination& combination, IcpOptions* icp);

// Sets the medians of the times. std::nullopt without reports; build_ms also if it is 0.
void SetTimes(const std::vector<SolveReport>& reports, SolveOutcome* outcome);

// Outcome of ICP. `points`: source points on the finest level, `total_ms`: duration of the call.
SolveOutcome OutcomeOf(const IcpResult& result, int points, double total_ms);

}  // namespace surfit
