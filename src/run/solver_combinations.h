#pragma once

#include <vector>

#include "surfit/run/compare_solvers.h"

namespace surfit {

inline constexpr char kKnownAssociation[] = "known";

// The combinations that the options ask for, residual by residual. Throws InputError that lists
// what is possible for unknown names, and for solvers and residuals that were both named and do not
// go together.
std::vector<SolverCombination> SolverCombinations(const CompareOptions& options);

// Whether a combination is so slow that it runs on little.
bool IsSlow(const SolverCombination& combination);

}  // namespace surfit
