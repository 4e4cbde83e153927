#pragma once

#include <string>
#include <vector>

#include "run/comparison_rows.h"

namespace surfit {

// Writes convergence.png (loss per iteration from one start on the grid's diagonal), time.png and,
// where the truth is known, basin.png (share converged over perturbation) into the folder.
// Throws InputError naming the file that cannot be written.
void WriteComparisonPictures(const std::vector<ComparedRuns>& all,
                             const std::vector<ComparisonRow>& rows, const CompareOptions& options);

}  // namespace surfit
