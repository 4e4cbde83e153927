#pragma once

#include <ceres/types.h>

#include "core/named_values.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Values of PoseGraphOptions with their names.
enum class PoseGraphStart { kGiven, kOdometry, kChordal };
enum class LoopRobustness { kNone, kGnc, kDcs, kHuber, kCauchy, kGemanMcClure, kAuto };
enum class OdometryRule { kConsecutive, kSpanningTree, kNone };

inline constexpr NamedValue<ceres::SparseLinearAlgebraLibraryType> kSparseBackends[] = {
    {"suite_sparse", ceres::SUITE_SPARSE}, {"eigen_sparse", ceres::EIGEN_SPARSE}};

inline constexpr NamedValue<PoseGraphStart> kPoseGraphStarts[] = {
    {"given", PoseGraphStart::kGiven},
    {"odometry", PoseGraphStart::kOdometry},
    {"chordal", PoseGraphStart::kChordal}};

inline constexpr NamedValue<LoopRobustness> kLoopRobustness[] = {
    {"none", LoopRobustness::kNone},     {"gnc", LoopRobustness::kGnc},
    {"dcs", LoopRobustness::kDcs},       {"huber", LoopRobustness::kHuber},
    {"cauchy", LoopRobustness::kCauchy}, {"geman_mcclure", LoopRobustness::kGemanMcClure},
    {"auto", LoopRobustness::kAuto}};

inline constexpr NamedValue<OdometryRule> kOdometryRules[] = {
    {"consecutive", OdometryRule::kConsecutive},
    {"spanning_tree", OdometryRule::kSpanningTree},
    {"none", OdometryRule::kNone}};

inline constexpr NamedValue<PoseGraphTermination> kTerminations[] = {
    {"converged", PoseGraphTermination::kConverged},
    {"max_iterations", PoseGraphTermination::kMaxIterations},
    {"failed", PoseGraphTermination::kFailed}};

}  // namespace surfit
