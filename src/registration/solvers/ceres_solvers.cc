#include <ceres/autodiff_cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/named_values.h"
#include "cost_functions/kernel_loss.h"
#include "registration/icp/own_residuals.h"
#include "registration/solvers/functor_batch.h"
#include "registration/solvers/reduced_solver.h"

namespace surfit {
namespace {

constexpr NamedValue<ceres::LinearSolverType> kLinearSolvers[] = {
    {"dense_qr", ceres::DENSE_QR},
    {"dense_normal_cholesky", ceres::DENSE_NORMAL_CHOLESKY},
    {"sparse_normal_cholesky", ceres::SPARSE_NORMAL_CHOLESKY}};

// Minimises a cost over a pose increment. The initial increment is the identity.
//
// Ceres discards the step that ends a solve by the function tolerance. For a tolerance above
// numerical precision, this step is most of the remaining distance to the minimum. Therefore the
// last evaluated pose is used.
class PoseProblem final : private ceres::EvaluationCallback {
 public:
  PoseProblem() : problem_(ProblemOptions(this)) {
    problem_.AddParameterBlock(pose_.data(), kPoseSize, new LeftPoseManifold);
  }

  // `loss` must outlive the problem. It can be null.
  void Add(ceres::CostFunction* cost, ceres::LossFunction* loss = nullptr) {
    problem_.AddResidualBlock(cost, loss, pose_.data());
  }

  // Returns the increment as a tangent vector. S: scalar type of the pairs.
  template <typename S>
  Vector6d Solve(ceres::LinearSolverType type, double min_relative_cost_change,
                 SolveReport* report) {
    ceres::Solver::Options options;
    options.function_tolerance = std::max(LmTolerances<S>::kFunction, min_relative_cost_change);
    options.gradient_tolerance = LmTolerances<S>::kGradient;
    options.parameter_tolerance = LmTolerances<S>::kParameter;
    options.max_num_iterations = LmTolerances<S>::kMaxIterations;
    options.linear_solver_type = type;
    options.num_threads = 1;  // reduced blocks use threads; sums have a fixed order
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    const Stopwatch solving;
    ceres::Solve(options, &problem_, &summary);
    report->solve_ms = solving.Milliseconds();
    Describe(summary, report);
    // Ceres converges before it accepts the last point, which usually has the least cost. If the
    // tolerance is large, the difference matters.
    const bool may_be_better = summary.termination_type == ceres::CONVERGENCE &&
                               options.function_tolerance > LmTolerances<S>::kFunction;
    if (may_be_better) TakeLastIfBetter();
    return AsIncrement(pose_);
  }

 private:
  static ceres::Problem::Options ProblemOptions(ceres::EvaluationCallback* callback) {
    ceres::Problem::Options options;
    options.evaluation_callback = callback;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  static void Describe(const ceres::Solver::Summary& summary, SolveReport* report) {
    report->linearize_ms = 1000 * summary.jacobian_evaluation_time_in_seconds /
                           std::max(1, summary.num_jacobian_evaluations);
    report->costs.clear();
    for (const ceres::IterationSummary& iteration : summary.iterations) {
      if (iteration.iteration == 0 || iteration.step_is_successful) {
        report->costs.push_back(iteration.cost);
      }
    }
  }

  void TakeLastIfBetter() {
    const PoseBlock accepted = pose_, last = last_;
    if (accepted == last) return;
    double accepted_cost = 0, last_cost = 0;
    const bool is_known = problem_.Evaluate({}, &accepted_cost, nullptr, nullptr, nullptr);
    pose_ = last;
    const bool is_better = is_known &&
                           problem_.Evaluate({}, &last_cost, nullptr, nullptr, nullptr) &&
                           last_cost < accepted_cost;
    if (!is_better) pose_ = accepted;
  }

  void PrepareForEvaluation(bool, bool) override { last_ = pose_; }

  PoseBlock pose_ = IdentityBlock();
  PoseBlock last_ = pose_;
  ceres::Problem problem_;
};

// Reduced block that remembers its costs, because PoseProblem repeats the last evaluations.
class RememberingBlock final : public ceres::CostFunction {
 public:
  explicit RememberingBlock(std::unique_ptr<ReducedBlock> block) : block_(std::move(block)) {
    *mutable_parameter_block_sizes() = block_->parameter_block_sizes();
    set_num_residuals(block_->num_residuals());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    if (jacobians != nullptr) return block_->Evaluate(parameters, residuals, jacobians);
    PoseBlock pose;
    std::copy_n(parameters[0], kPoseSize, pose.begin());
    const auto known = std::find_if(costs_.begin(), costs_.end(),
                                    [&](const Cost& cost) { return cost.pose == pose; });
    if (known != costs_.end()) {
      std::fill_n(residuals, num_residuals(), 0.);
      residuals[0] = known->residual;
      return true;
    }
    if (!block_->Evaluate(parameters, residuals, nullptr)) return false;
    costs_.push_back({pose, residuals[0]});
    return true;
  }

 private:
  struct Cost {
    PoseBlock pose;
    double residual;  // the only one that is not zero, see ReducedBatch
  };

  std::unique_ptr<ReducedBlock> block_;
  mutable std::vector<Cost> costs_;
};

class ReducedCeresSolver final : public ReducedSolver<ReducedCeresSolver> {
 public:
  using ReducedSolver::ReducedSolver;

  template <typename S>
  Vector6d Minimum(ReducedBlocks blocks, std::unique_ptr<ceres::CostFunction> prior,
                   const StepResult&, SolveReport* report) const {
    PoseProblem problem;
    for (auto& block : blocks) problem.Add(new RememberingBlock(std::move(block)));
    if (prior) problem.Add(prior.release());
    return problem.Solve<S>(ceres::DENSE_QR, options().min_relative_cost_change, report);
  }
};

class PerPointCeresSolver final : public PairSolver<PerPointCeresSolver> {
 public:
  PerPointCeresSolver(const PoseSolverOptions& options, ceres::LinearSolverType linear_solver)
      : PairSolver(options), linear_solver_(linear_solver) {}

  bool ReachesMinimum() const override { return true; }

  template <typename S>
  Vector6d Solve(Pairs<S> pairs, const RobustKernel& kernel, const IntensityPairs& intensities,
                 const Rigid3d* pose, const StepResult&, SolveReport* report) const {
    const Stopwatch building;
    KernelLoss loss(kernel),
        intensity_loss(photometric() != nullptr ? photometric()->kernel() : kernel);
    PoseProblem problem;
    AddPairs(std::move(pairs), kernel.type == RobustKernelType::kNone ? nullptr : &loss, &problem);
    if (intensities.size > 0) {
      AddBlocks(MakeBatch(intensities, *photometric()), FunctorOf(photometric()->camera()),
                &intensity_loss, &problem);
    }
    if (pose != nullptr) problem.Add(MakePriorCost(*prior(), *pose).release());
    report->build_ms = building.Milliseconds();
    return problem.Solve<S>(linear_solver_, options().min_relative_cost_change, report);
  }

 private:
  template <typename S>
  void AddPairs(Pairs<S> pairs, ceres::LossFunction* loss, PoseProblem* problem) const {
    if (const OwnResidual* const own = OwnResidualOf(options().residual)) {
      for (int i = 0; i < pairs.size; ++i) problem->Add(own->OfPair(pairs, i).release(), loss);
      return;
    }
    WithFunctorOf(options().residual, [&](const auto& functor) {
      AddBlocks(MakeBatch(std::move(pairs), functor), functor, loss, problem);
    });
  }

  template <typename Functor, typename S>
  static void AddBlocks(const BatchData<Functor, S>& batch, const Functor& prototype,
                        ceres::LossFunction* loss, PoseProblem* problem) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      auto* functor = new Functor(prototype);
      for (int k = 0; k < Functor::kDataSize; ++k) functor->data[k] = batch.array(k)[i];
      problem->Add(
          new ceres::AutoDiffCostFunction<Functor, Functor::kResidualSize, kPoseSize>(functor),
          loss);
    }
  }

  ceres::LinearSolverType linear_solver_;
};

}  // namespace

std::vector<std::string> LinearSolverNames() { return NamesOf(kLinearSolvers); }

std::unique_ptr<PoseSolver> MakeCeresSolver(const PoseSolverOptions& options) {
  if (options.name == "ceres") return std::make_unique<ReducedCeresSolver>(options);
  if (options.name == "ceres_per_point") {
    return std::make_unique<PerPointCeresSolver>(
        options, ValueOf("linear_solver", options.linear_solver, kLinearSolvers));
  }
  return nullptr;
}

}  // namespace surfit
