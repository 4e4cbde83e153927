#include "optimization/pose_graph_equations.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// What an unmeasured direction is damped by, as in Ceres: of columns scaled to length n / (1 + n).
constexpr double kLeastScaledDiagonal = 1e-6;

}  // namespace

PoseGraphEquations::PoseGraphEquations(const PoseGraphProblem& problem)
    : unknowns_(NumberUnknowns(problem.graph, problem.held)),
      cholesky_(unknowns_.count, unknowns_.pairs),
      matrix_(kPoseTangentSize, unknowns_.count, unknowns_.pairs.size()),
      gradient_(kPoseTangentSize * unknowns_.count) {}

void PoseGraphEquations::Linearize(const PoseGraphProblem& problem) {
  matrix_.SetZero();
  gradient_.setZero();
  std::size_t pair = 0;
  for (std::size_t i = 0; i < problem.costs.size(); ++i) {
    const PoseGraphEdge& edge = problem.graph.edges[i];
    Vector6d residuals;
    AnalyticRelativePose::Derivatives j;
    problem.costs[i]->EvaluateIncrements(problem.world_from_pose[edge.a],
                                         problem.world_from_pose[edge.b], residuals.data(), &j);
    const double weight = problem.weights[i];
    const int a = unknowns_.numbers[edge.a], b = unknowns_.numbers[edge.b];
    const auto add_own = [&](int number, const Matrix6d& by_pose) {
      if (number == kHeld) return;
      matrix_.Diagonal(number) += Matrix6d(weight * by_pose.transpose() * by_pose);
      gradient_.segment<6>(6 * number) += weight * by_pose.transpose() * residuals;
    };
    add_own(a, j.by_a);
    add_own(b, j.by_b);
    if (a != kHeld && b != kHeld) {
      matrix_.OffDiagonal(pair++) = Matrix6d(weight * j.by_b.transpose() * j.by_a);
    }
  }
}

Eigen::VectorXd PoseGraphEquations::Damping(double radius) const {
  Eigen::VectorXd damping(gradient_.size());
  for (int i = 0; i < unknowns_.count; ++i) {
    const Vector6d diagonal = matrix_.Diagonal(i).diagonal();
    for (int j = 0; j < 6; ++j) {
      const double scale = 1 + std::sqrt(diagonal[j]);
      damping[6 * i + j] = std::max(diagonal[j], kLeastScaledDiagonal * scale * scale) / radius;
    }
  }
  return damping;
}

// With (H + D) d = -g the linearised cost changes by g.d + 1/2 d.H d = 1/2 (g.d - d.D d).
std::optional<PoseGraphStep> PoseGraphEquations::Solve(double radius) {
  const Eigen::VectorXd damping = Damping(radius);
  BlockMatrix damped = matrix_;
  for (int i = 0; i < unknowns_.count; ++i) {
    damped.Diagonal(i).diagonal() += damping.segment<6>(6 * i);
  }
  if (!cholesky_.Factorize(damped)) return std::nullopt;
  PoseGraphStep step;
  step.increments = cholesky_.Solve(-gradient_);
  if (!step.increments.allFinite()) return std::nullopt;
  step.cost_decrease = (step.increments.dot(damping.cwiseProduct(step.increments)) -
                        gradient_.dot(step.increments)) /
                       2;
  return step;
}

}  // namespace surfit
