#pragma once

#include <string>
#include <vector>

#include "run/comparison_rows.h"

namespace surfit {

// Writes comparison.html into the output folder, a page that needs no other file: times, shares
// that converged over the perturbation (where the truth is known), the loss at each iteration from
// one start on the grid's diagonal, and all figures. Writes nothing where nothing ran. Throws
// InputError naming the file if it cannot be written.
void WriteComparisonPage(const std::vector<ComparedRuns>& all,
                         const std::vector<std::string>& notes, const CompareOptions& options);

}  // namespace surfit
