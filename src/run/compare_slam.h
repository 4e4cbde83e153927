#pragma once

#include <vector>

#include "surfit/run/compare_solvers.h"

namespace surfit {

// Runs SLAM over the options' sequence with every combination, into folders of <output>/slam.
std::vector<SlamComparisonRow> CompareSlam(
    const CompareOptions& options, const std::atomic<bool>& interrupted,
    const std::function<void(const CompareProgress&)>& progress);

}  // namespace surfit
