#include "optimization/pose_graph_problem.h"

namespace surfit {

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph_,
                                   const std::vector<Rigid3d>& world_from_pose_,
                                   const std::vector<bool>& held_)
    : graph(graph_),
      world_from_pose(world_from_pose_),
      held(held_),
      weights(graph_.edges.size(), 1) {
  for (const PoseGraphEdge& edge : graph.edges) {
    costs.push_back(std::make_unique<AnalyticRelativePose>(edge.a_from_b, edge.information));
  }
}

std::vector<double> PoseGraphProblem::SquaredErrors() const {
  std::vector<double> errors;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const PoseGraphEdge& edge = graph.edges[i];
    Eigen::Matrix<double, 6, 1> residuals;
    costs[i]->EvaluateIncrements(world_from_pose[edge.a], world_from_pose[edge.b], residuals.data(),
                                 nullptr);
    errors.push_back(residuals.squaredNorm());
  }
  return errors;
}

}  // namespace surfit
