#pragma once

#include "core/named_values.h"
#include "surfit/optimization/optimize_pose_graph.h"

namespace surfit {

// The choices of PoseGraphOptions and their names.
enum class SparseBackend { kMultifrontal, kSuiteSparse, kEigenSparse };
enum class PoseGraphInitialization { kGiven, kOdometry, kChordal };
enum class LoopRobustness { kNone, kGnc };

inline constexpr NamedValue<SparseBackend> kSparseBackends[] = {
    {"multifrontal", SparseBackend::kMultifrontal},
    {"suite_sparse", SparseBackend::kSuiteSparse},
    {"eigen_sparse", SparseBackend::kEigenSparse}};

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
