#include "surfit/registration/icp.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/free_space.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

int CountValid(const FrameLevel& level) {
  const auto& z = level.vertex.z;
  return static_cast<int>(std::count_if(z.begin(), z.end(), [](float depth) { return depth > 0; }));
}

AssociationGates GatesOfLevel(const IcpOptions& options, int level) {
  AssociationGates gates = options.gates;
  gates.max_distance_m *= std::pow(options.gate_growth, level);
  return gates;
}

ErrorModel ErrorModelOfLevel(const IcpOptions& options, int level) {
  ErrorModel error_model = options.error_model;
  error_model.kernel_width *= std::pow(options.kernel_growth, level);
  return error_model;
}

// One resolution of the registration.
class LevelIcp {
 public:
  LevelIcp(const FrameLevel& source, const FrameLevel& target, int level, const PoseSolver& solver,
           const IcpOptions& options)
      : association_(source, target, GatesOfLevel(options, level),
                     ErrorModelOfLevel(options, level)),
        focal_px_(target.camera.fx),
        solver_(solver),
        options_(options),
        level_(level),
        valid_count_(CountValid(source)) {}

  // Iterates from result->target_from_source until one of the terminations holds.
  void Run(IcpResult* result) const {
    double last_rmse = 0;
    result->termination = Termination::kMaxIterations;
    for (int i = 0; i < options_.max_iterations; ++i) {
      const StepResult step = solver_.Step(association_, result->target_from_source);
      Describe(step.system, step.smallest_eigenvalue, result);
      if (Failed(step.system, step.singular, result)) return;
      result->target_from_source = LeftIncrement(step.increment, result->target_from_source);
      ++result->step_count;
      if (Converged(step, last_rmse)) {
        result->termination = Termination::kConverged;
        break;
      }
      last_rmse = std::sqrt(step.system.AverageLoss());
    }
    const NormalSystem system = association_.Linearize(result->target_from_source);
    const double smallest_eigenvalue = system.ScaledEigenvalues()[0];
    Describe(system, smallest_eigenvalue, result);
    Failed(system, !(smallest_eigenvalue > options_.min_eigenvalue), result);
  }

 private:
  bool Failed(const NormalSystem& system, bool singular, IcpResult* result) const {
    const double needed =
        std::max<double>(options_.min_inliers, options_.min_inlier_share * valid_count_);
    if (system.pair_count < needed) {
      result->termination = Termination::kTooFewInliers;
      return true;
    }
    if (singular) result->termination = Termination::kSingularSystem;
    return singular;
  }

  bool Converged(const StepResult& step, double last_rmse) const {
    const double turn_rad = step.increment.head<3>().norm();
    const double shift_m = step.increment.tail<3>().norm();
    if (turn_rad < options_.min_increment && shift_m < options_.min_increment) return true;
    const double step_px = focal_px_ * (turn_rad + shift_m / step.system.RmsDistance());
    if (level_ > 0 && step_px < options_.min_coarse_step_px) return true;
    const double rmse = std::sqrt(step.system.AverageLoss());
    return last_rmse > 0 &&
           std::abs(rmse - last_rmse) < options_.min_relative_rmse_change * last_rmse;
  }

  void Describe(const NormalSystem& system, double smallest_eigenvalue, IcpResult* result) const {
    result->iterations.push_back({level_, system.AverageLoss(), system.inlier_count});
    result->inlier_count = system.inlier_count;
    result->inlier_share =
        valid_count_ > 0 ? static_cast<double>(system.inlier_count) / valid_count_ : 0;
    result->rmse_m = std::sqrt(system.AverageLoss());
    result->hessian = system.hessian;
    result->smallest_eigenvalue = smallest_eigenvalue;
  }

  ProjectiveAssociation association_;
  double focal_px_;
  const PoseSolver& solver_;
  const IcpOptions& options_;
  int level_;
  int valid_count_;
};

// Rejects a fit after which one view's surfaces stand in what the other saw through.
void CheckFreeSpace(const FrameLevel& source, const FrameLevel& target, const IcpOptions& options,
                    IcpResult* result) {
  if (options.max_free_space_share >= 1) return;
  const Rigid3d& pose = result->target_from_source;
  result->free_space_share =
      std::max(FreeSpaceShare(source, target, options.error_model, pose),
               FreeSpaceShare(target, source, options.error_model, pose.Inverse()));
  if (result->free_space_share > options.max_free_space_share) {
    result->termination = Termination::kFreeSpaceFilled;
  }
}

}  // namespace

std::string ToString(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged";
    case Termination::kMaxIterations:
      return "max_iterations";
    case Termination::kTooFewInliers:
      return "too_few_inliers";
    case Termination::kSingularSystem:
      return "singular_system";
    case Termination::kFreeSpaceFilled:
      return "free_space_filled";
  }
  return "unknown";
}

IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options) {
  options.Validate();
  const std::unique_ptr<PoseSolver> solver =
      MakePoseSolver({options.solver, options.linear_solver, options.min_eigenvalue});
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  const int levels = static_cast<int>(std::min(source.levels.size(), target.levels.size()));
  for (int level = levels - 1; level >= 0; --level) {
    if (!options.middle_levels && level > 0 && level < levels - 1) continue;
    const LevelIcp icp(source.levels[level], target.levels[level], level, *solver, options);
    icp.Run(&result);
    if (!result.Succeeded()) return result;
  }
  if (levels > 0) CheckFreeSpace(source.levels[0], target.levels[0], options, &result);
  return result;
}

}  // namespace surfit
