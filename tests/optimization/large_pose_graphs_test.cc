#include <gtest/gtest.h>

#include <iostream>

#include "surfit/optimization/optimize_pose_graph.h"
#include "testing/pose_graphs.h"

namespace surfit {
namespace {

using testing::TrueGraph;

class LargePoseGraphs : public ::testing::TestWithParam<const char*> {
 protected:
  static TrueGraph Make(const std::string& shape) {
    if (shape == "sphere") return testing::MakeSphere(316, 317);  // 100,172 poses
    return shape == "torus" ? testing::MakeTorus(316, 317) : testing::MakeGrid(20);  // 8,000 poses
  }
};

TEST_P(LargePoseGraphs, ConvergeToOneCostWithEveryBackend) {
  const TrueGraph given = Make(GetParam());
  std::vector<double> costs;
  for (const std::string& backend : SparseBackendNames()) {
    PoseGraphOptions options;
    options.sparse_backend = backend;
    PoseGraph graph = given.graph;
    const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
    std::cout << GetParam() << " " << backend << ": " << summary.iterations.size() - 1
              << " iterations, " << summary.initialize_ms / 1000 << " s initialised, "
              << summary.solve_ms / 1000 << " s solved, cost " << summary.final_cost << std::endl;
    costs.push_back(summary.final_cost);
    EXPECT_NEAR(costs.back(), costs.front(), 1e-9 * costs.front()) << backend;
  }
}

INSTANTIATE_TEST_SUITE_P(, LargePoseGraphs, ::testing::Values("sphere", "torus", "grid"));

}  // namespace
}  // namespace surfit
