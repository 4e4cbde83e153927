#include <ceres/ceres.h>
#include <ceres/tiny_solver.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/reduced_batch.h"
#include "registration/pair_batch.h"
#include "registration/solver_factories.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using PoseBlock = std::array<double, kPoseSize>;
using Batch = BatchData<PointToPlane, float>;

RobustKernel KernelOf(const ErrorModel& error_model) {
  if (error_model.kernel_width == 0) return {};
  return {RobustKernelType::kGemanMcClure, error_model.kernel_width};
}

// The pairs' points are already moved: the pose to solve for starts at the identity, and what it
// becomes is the left increment.
PoseBlock Identity() { return {0, 0, 0, 1, 0, 0, 0}; }

Vector6d AsIncrement(const PoseBlock& pose) {
  Vector6d increment;
  LeftPoseManifold().Minus(pose.data(), Identity().data(), increment.data());
  return increment;
}

// Tolerances that single precision sums can meet, far below what moves an association.
void SetTolerances(ceres::Solver::Options* options) {
  options->function_tolerance = 1e-7;
  options->gradient_tolerance = 1e-10;
  options->parameter_tolerance = 1e-8;
  options->max_num_iterations = 20;
}

// A solver of the robust problem over the pairs that the association finds at the present pose.
class CeresSolver : public PoseSolver {
 public:
  explicit CeresSolver(double min_eigenvalue) : min_eigenvalue_(min_eigenvalue) {}

  StepResult Step(const ProjectiveAssociation& association,
                  const Rigid3d& target_from_source) const override {
    std::vector<PairBuffer> rows = association.CollectRows(target_from_source);
    StepResult result;
    result.system =
        ParallelSum(0, static_cast<int>(rows.size()), 8, NormalSystem(), [&](int begin, int end) {
          NormalSystem system;
          for (int v = begin; v < end; ++v) AddPairs(&rows[v], &system);
          return system;
        });
    result.smallest_eigenvalue = result.system.ScaledEigenvalues()[0];
    result.singular = !(result.smallest_eigenvalue > min_eigenvalue_);
    if (result.singular) return result;
    result.increment = AsIncrement(Solve(MakeBatch(rows), KernelOf(association.error_model())));
    return result;
  }

 private:
  // The pose block that minimises 1/2 sum rho(r^2) over the batch.
  virtual PoseBlock Solve(Batch batch, const RobustKernel& kernel) const = 0;

  double min_eigenvalue_;
};

PoseBlock SolveProblem(ceres::Problem* problem, PoseBlock* pose, ceres::LinearSolverType type) {
  ceres::Solver::Options options;
  SetTolerances(&options);
  options.linear_solver_type = type;
  options.num_threads = 1;  // the reduced block has its own; sums over points must keep their order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  return *pose;
}

class ReducedCeresSolver final : public CeresSolver {
 public:
  using CeresSolver::CeresSolver;

 private:
  PoseBlock Solve(Batch batch, const RobustKernel& kernel) const override {
    PoseBlock pose = Identity();
    ceres::Problem problem;
    problem.AddParameterBlock(pose.data(), kPoseSize, new LeftPoseManifold);
    problem.AddResidualBlock(
        new ReducedBatch<PointToPlane>(PointToPlane(), std::move(batch), kernel), nullptr,
        pose.data());
    return SolveProblem(&problem, &pose, ceres::DENSE_QR);
  }
};

// A kernel as Ceres' loss. Its second derivative is given as zero: Ceres leaves negative ones out
// of the step as well, and rho is concave.
class KernelLoss final : public ceres::LossFunction {
 public:
  explicit KernelLoss(const RobustKernel& kernel) : kernel_(kernel) {}
  void Evaluate(double s, double rho[3]) const override {
    const KernelValue<double> value = WithKernelType(kernel_.type, [&](auto type) {
      return EvaluateKernel<decltype(type)::value>(s, kernel_.width);
    });
    rho[0] = value.rho;
    rho[1] = value.slope;
    rho[2] = 0;
  }

 private:
  RobustKernel kernel_;
};

class PerPointCeresSolver final : public CeresSolver {
 public:
  PerPointCeresSolver(double min_eigenvalue, ceres::LinearSolverType linear_solver)
      : CeresSolver(min_eigenvalue), linear_solver_(linear_solver) {}

 private:
  PoseBlock Solve(Batch batch, const RobustKernel& kernel) const override {
    PoseBlock pose = Identity();
    KernelLoss loss(kernel);
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    problem.AddParameterBlock(pose.data(), kPoseSize, new LeftPoseManifold);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      auto* functor = new PointToPlane;
      for (int k = 0; k < PointToPlane::kDataSize; ++k) functor->data[k] = batch.array(k)[i];
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointToPlane, 1, kPoseSize>(functor),
                               &loss, pose.data());
    }
    return SolveProblem(&problem, &pose, linear_solver_);
  }

  ceres::LinearSolverType linear_solver_;
};

// The reduced block for TinySolver, whose six parameters are (w, v) of the pose (exp(w), v).
struct TinyFunction {
  using Scalar = double;
  enum { NUM_RESIDUALS = 7, NUM_PARAMETERS = 6 };

  // `jacobian` is stored by columns.
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
    if (jacobian == nullptr) return cost->Evaluate(&parameters, residuals, nullptr);
    Eigen::Matrix<double, NUM_RESIDUALS, kPoseSize, Eigen::RowMajor> by_pose;
    double* jacobians = by_pose.data();
    if (!cost->Evaluate(&parameters, residuals, &jacobians)) return false;
    Eigen::Map<Eigen::Matrix<double, NUM_RESIDUALS, NUM_PARAMETERS>> by_x(jacobian);
    by_x = by_pose * pose_by_x;
    return true;
  }

  const ceres::CostFunction* cost;
};

class TinyPoseSolver final : public CeresSolver {
 public:
  using CeresSolver::CeresSolver;

 private:
  PoseBlock Solve(Batch batch, const RobustKernel& kernel) const override {
    const ReducedBatch<PointToPlane> cost(PointToPlane(), std::move(batch), kernel);
    ceres::TinySolver<TinyFunction> solver;
    solver.options.max_num_iterations = 20;
    solver.options.gradient_tolerance = 1e-10;
    solver.options.parameter_tolerance = 1e-8;
    solver.options.function_tolerance = 1e-7;
    Vector6d x = Vector6d::Zero();
    solver.Solve({&cost}, &x);
    PoseBlock pose;
    PoseToBlock(LeftIncrement<double>(x, Rigid3d()), pose.data());
    return pose;
  }
};

struct NamedLinearSolver {
  const char* name;
  ceres::LinearSolverType type;
};
constexpr NamedLinearSolver kLinearSolvers[] = {
    {"dense_qr", ceres::DENSE_QR},
    {"dense_normal_cholesky", ceres::DENSE_NORMAL_CHOLESKY},
    {"sparse_normal_cholesky", ceres::SPARSE_NORMAL_CHOLESKY}};

ceres::LinearSolverType LinearSolverOf(const std::string& name) {
  std::string known;
  for (const NamedLinearSolver& solver : kLinearSolvers) {
    if (name == solver.name) return solver.type;
    known += (known.empty() ? "" : ", ") + std::string(solver.name);
  }
  throw InputError(Concat("linear_solver is '", name, "', must be one of: ", known));
}

}  // namespace

std::vector<std::string> LinearSolverNames() {
  std::vector<std::string> names;
  for (const NamedLinearSolver& solver : kLinearSolvers) names.emplace_back(solver.name);
  return names;
}

std::unique_ptr<PoseSolver> MakeCeresSolver(const PoseSolverOptions& options) {
  if (options.name == "ceres") return std::make_unique<ReducedCeresSolver>(options.min_eigenvalue);
  if (options.name == "tiny") return std::make_unique<TinyPoseSolver>(options.min_eigenvalue);
  if (options.name == "ceres_per_point") {
    return std::make_unique<PerPointCeresSolver>(options.min_eigenvalue,
                                                 LinearSolverOf(options.linear_solver));
  }
  return nullptr;
}

}  // namespace surfit
