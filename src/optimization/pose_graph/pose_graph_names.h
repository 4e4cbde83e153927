#pragma once

#include <ceres/types.h>

#include "core/named_values.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Values of PoseGraphOptions, with their names in flags and files.
enum class PoseGraphInitialization { kGiven, kOdometry, kChordal };
enum class LoopRobustness { kNone, kGnc };

inline constexpr NamedValue<ceres::SparseLinearAlgebraLibraryType> kSparseBackends[] = {
    {"suite_sparse", ceres::SUITE_SPARSE}, {"eigen_sparse", ceres::EIGEN_SPARSE}};

inline constexpr NamedValue<PoseGraphInitialization> kInitializations[] = {
    {"given", PoseGraphInitialization::kGiven},
    {"odometry", PoseGraphInitialization::kOdometry},
    {"chordal", PoseGraphInitialization::kChordal}};

inline constexpr NamedValue<LoopRobustness> kLoopRobustness[] = {{"none", LoopRobustness::kNone},
                                                                 {"gnc", LoopRobustness::kGnc}};

inline constexpr NamedValue<PoseGraphTermination> kTerminations[] = {
    {"converged", PoseGraphTermination::kConverged},
    {"max_iterations", PoseGraphTermination::kMaxIterations},
    {"failed", PoseGraphTermination::kFailed}};

}  // namespace surfit
