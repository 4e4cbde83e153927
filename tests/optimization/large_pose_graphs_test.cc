#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "surfit/optimization/optimize_pose_graph.h"
#include "testing/pose_graphs.h"

namespace surfit {
namespace {

using testing::TrueGraph;

struct Case {
  const char* shape;
  const char* backend;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.shape << " " << c.backend;
}

class LargePoseGraphs : public ::testing::TestWithParam<Case> {
 protected:
  static TrueGraph Make(const std::string& shape) {
    if (shape == "sphere") return testing::MakeSphere(316, 317);  // 100,172 poses
    return shape == "torus" ? testing::MakeTorus(316, 317) : testing::MakeGrid(20);  // 8,000 poses
  }
};

double OptimizedCost(PoseGraph graph, const std::string& backend) {
  PoseGraphOptions options;
  options.sparse_backend = backend;
  const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  std::cout << backend << ": " << summary.iterations.size() - 1 << " iterations, "
            << summary.initialize_ms / 1000 << " s initialised, " << summary.solve_ms / 1000
            << " s solved, cost " << summary.final_cost << std::endl;
  return summary.final_cost;
}

TEST_P(LargePoseGraphs, ConvergeToOneCost) {
  const std::vector<std::string> known = SparseBackendNames();
  if (std::find(known.begin(), known.end(), GetParam().backend) == known.end()) {
    GTEST_SKIP() << "this build has no " << GetParam().backend;
  }
  const TrueGraph given = Make(GetParam().shape);
  const double expected = OptimizedCost(given.graph, known.front());
  EXPECT_NEAR(OptimizedCost(given.graph, GetParam().backend), expected, 1e-9 * expected);
}

// eigen_sparse would take too long for the larger ones.
INSTANTIATE_TEST_SUITE_P(, LargePoseGraphs,
                         ::testing::Values(Case{"sphere", "suite_sparse"},
                                           Case{"torus", "suite_sparse"},
                                           Case{"grid", "suite_sparse"},
                                           Case{"grid", "eigen_sparse"}));

}  // namespace
}  // namespace surfit
