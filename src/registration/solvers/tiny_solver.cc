#include <ceres/jet.h>
#include <ceres/tiny_solver.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/row_sums.h"
#include "registration/solvers/decompositions.h"
#include "registration/solvers/reduced_solver.h"

namespace surfit {
namespace {

// Reduced blocks as a function for ceres::TinySolver. Parameters: rotation vector w and translation
// v of the pose increment (exp(w), v).
template <int kBlocks>
struct TinyFunction {
  using Scalar = double;
  enum { NUM_RESIDUALS = kBlocks * kRowColumns, NUM_PARAMETERS = kPoseTangentSize };

  // `jacobian` is column-major.
  bool operator()(const double* x, double* residuals, double* jacobian) const {
    using Jet = ceres::Jet<double, NUM_PARAMETERS>;
    Eigen::Matrix<Jet, 3, 1> w, v;
    for (int i = 0; i < 3; ++i) {
      w[i] = Jet(x[i], i);
      v[i] = Jet(x[3 + i], 3 + i);
    }
    Jet moving[kPoseSize];
    PoseToBlock(Rigid3<Jet>(QuaternionExp<Jet>(w), v), moving);
    double pose[kPoseSize];
    Eigen::Matrix<double, kPoseSize, NUM_PARAMETERS> pose_by_x;
    for (int i = 0; i < kPoseSize; ++i) {
      pose[i] = moving[i].a;
      pose_by_x.row(i) = moving[i].v.transpose();
    }
    const double* parameters = pose;
    Eigen::Matrix<double, NUM_RESIDUALS, kPoseSize, Eigen::RowMajor> by_pose;
    for (int i = 0; i < kBlocks; ++i) {
      double* rows = by_pose.row(i * kRowColumns).data();
      if (!costs[i]->Evaluate(&parameters, residuals + i * kRowColumns,
                              jacobian == nullptr ? nullptr : &rows)) {
        return false;
      }
    }
    if (jacobian == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, NUM_RESIDUALS, NUM_PARAMETERS>> by_x(jacobian);
    by_x = by_pose * pose_by_x;
    report->costs.push_back(
        0.5 * Eigen::Map<const Eigen::Matrix<double, NUM_RESIDUALS, 1>>(residuals).squaredNorm());
    return true;
  }

  std::array<const ceres::CostFunction*, kBlocks> costs;
  SolveReport* report;
};

// Linear solver with the interface of ceres::TinySolver.
class CompiledLdlt {
 public:
  void compute(const Matrix6d& matrix) { matrix_ = matrix; }
  Vector6d solve(const Vector6d& right_side) const { return SolveLdlt(matrix_, right_side); }

 private:
  Matrix6d matrix_;
};

class TinyPoseSolver final : public ReducedSolver<TinyPoseSolver> {
 public:
  using ReducedSolver::ReducedSolver;

  template <typename S>
  Vector6d Minimum(const ReducedBlocks& blocks, const std::unique_ptr<ceres::CostFunction>& prior,
                   const StepResult& before, SolveReport* report) const {
    std::vector<const ceres::CostFunction*> costs;
    for (const auto& block : blocks) costs.push_back(block.get());
    if (prior) costs.push_back(prior.get());
    if (costs.size() == 1) return MinimumOf<S, 1>({costs[0]}, before, report);
    if (costs.size() == 2) return MinimumOf<S, 2>({costs[0], costs[1]}, before, report);
    return MinimumOf<S, 3>({costs[0], costs[1], costs[2]}, before, report);
  }

 private:
  template <typename S, int kBlocks>
  Vector6d MinimumOf(const std::array<const ceres::CostFunction*, kBlocks>& costs,
                     const StepResult& before, SolveReport* report) const {
    using Function = TinyFunction<kBlocks>;
    ceres::TinySolver<Function, CompiledLdlt> solver;
    solver.options.max_num_iterations = LmTolerances<S>::kMaxIterations;
    solver.options.gradient_tolerance = LmTolerances<S>::kGradient;
    solver.options.parameter_tolerance = LmTolerances<S>::kParameter;
    // TinySolver has absolute tolerances, unlike ceres::Solver.
    solver.options.function_tolerance =
        std::max(LmTolerances<S>::kFunction, options().min_relative_cost_change) *
        (before.system.JointCost() + before.prior_cost);
    solver.options.cost_threshold = 0;
    report->costs.clear();
    Vector6d x = Vector6d::Zero();
    solver.Solve(Function{costs, report}, &x);
    return x;  // the pose (exp(w), v) is the increment
  }
};

}  // namespace

std::unique_ptr<PoseSolver> MakeTinySolver(const PoseSolverOptions& options) {
  if (options.name != "tiny") return nullptr;
  return std::make_unique<TinyPoseSolver>(options);
}

}  // namespace surfit
