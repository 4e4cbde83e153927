#include "surfit/registration/icp.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
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

// One resolution of the registration.
class LevelIcp {
 public:
  LevelIcp(const FrameLevel& source, const FrameLevel& target, int level, const PoseSolver& solver,
           const IcpOptions& options)
      : association_(source, target, GatesOfLevel(options, level), options.error_model),
        solver_(solver),
        options_(options),
        level_(level),
        valid_count_(CountValid(source)) {}

  // Iterates from result->target_from_source until one of the terminations holds.
  void Run(IcpResult* result) const {
    double last_rmse = 0;
    for (int i = 0; i < options_.max_iterations; ++i) {
      const StepResult step = solver_.Step(association_, result->target_from_source);
      result->iterations.push_back({level_, step.system.AverageLoss(), step.system.inlier_count});
      Describe(step.system, step.smallest_eigenvalue, result);
      if (Failed(step, result)) return;
      result->target_from_source = LeftIncrement(step.increment, result->target_from_source);
      if (Converged(step, i == 0 ? 0 : last_rmse)) {
        result->termination = Termination::kConverged;
        return;
      }
      last_rmse = std::sqrt(step.system.AverageLoss());
    }
    result->termination = Termination::kMaxIterations;
  }

  // Describes the registration at the pose reached.
  void Finish(IcpResult* result) const {
    const NormalSystem system = association_.Linearize(result->target_from_source);
    Describe(system, system.ScaledEigenvalues()[0], result);
  }

 private:
  bool Failed(const StepResult& step, IcpResult* result) const {
    const double needed =
        std::max<double>(options_.min_inliers, options_.min_inlier_share * valid_count_);
    if (step.system.inlier_count < needed) {
      result->termination = Termination::kTooFewInliers;
      return true;
    }
    if (step.singular) result->termination = Termination::kSingularSystem;
    return step.singular;
  }

  bool Converged(const StepResult& step, double last_rmse) const {
    if (step.increment.head<3>().norm() < options_.min_increment &&
        step.increment.tail<3>().norm() < options_.min_increment) {
      return true;
    }
    const double rmse = std::sqrt(step.system.AverageLoss());
    return last_rmse > 0 &&
           std::abs(rmse - last_rmse) < options_.min_relative_rmse_change * last_rmse;
  }

  void Describe(const NormalSystem& system, double smallest_eigenvalue, IcpResult* result) const {
    result->inlier_count = system.inlier_count;
    result->inlier_share =
        valid_count_ > 0 ? static_cast<double>(system.inlier_count) / valid_count_ : 0;
    result->rmse_m = std::sqrt(system.AverageLoss());
    result->hessian = system.hessian;
    result->smallest_eigenvalue = smallest_eigenvalue;
  }

  ProjectiveAssociation association_;
  const PoseSolver& solver_;
  const IcpOptions& options_;
  int level_;
  int valid_count_;
};

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
  }
  return "unknown";
}

IcpResult Register(const FramePyramid& source, const FramePyramid& target,
                   const Rigid3d& target_from_source_initial, const IcpOptions& options) {
  options.Validate();
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(options.solver, options.min_eigenvalue);
  IcpResult result;
  result.target_from_source = target_from_source_initial;
  const int levels = static_cast<int>(std::min(source.levels.size(), target.levels.size()));
  for (int level = levels - 1; level >= 0; --level) {
    const LevelIcp icp(source.levels[level], target.levels[level], level, *solver, options);
    icp.Run(&result);
    if (!result.Succeeded()) return result;
    if (level == 0) icp.Finish(&result);
  }
  return result;
}

}  // namespace surfit
