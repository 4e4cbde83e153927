#include <gmock/gmock.h>

#include <iostream>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/optimization/pose_graph.h"
#include "testing/pose_graphs.h"

namespace surfit::testing {
namespace {

double Ate(const PoseGraph& graph, const std::vector<Rigid3d>& truth) {
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    poses.push_back({1. * i, truth[i], graph.poses[i].world_from_pose});
  }
  return ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse;
}

double OptimizedAte(TrueGraph graph, const PoseGraphOptions& options, PoseGraphSummary* summary) {
  *summary = OptimizePoseGraph(options, &graph.graph);
  return Ate(graph.graph, graph.truth);
}

// Adds 10 % wrong loops and expects that GNC rejects them.
void ExpectWrongLoopsAreFound(const TrueGraph& clean) {
  PoseGraphOptions options;
  options.max_iterations = 50;  // without GNC, wrong loops can need hundreds
  PoseGraphSummary summary;
  const double clean_ate = OptimizedAte(clean, options, &summary);

  TrueGraph wrong = clean;
  const std::vector<std::size_t> planted = PlantWrongLoops(0.1, &wrong);
  ASSERT_GT(planted.size(), 10u);
  EXPECT_GT(OptimizedAte(wrong, options, &summary),
            2 * clean_ate);  // wrong loops increase the error
  EXPECT_TRUE(summary.outlier_edges.empty());

  options.loop_robustness = "gnc";
  EXPECT_LT(OptimizedAte(wrong, options, &summary), 1.1 * clean_ate);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  EXPECT_THAT(summary.outlier_edges, ::testing::IsSupersetOf(planted));
  // The threshold rejects one correct loop of 1000. The bound of 1 % has a margin for small counts.
  EXPECT_LE(summary.outlier_edges.size(), planted.size() + 0.01 * summary.loop_count);
}

TEST(WrongLoops, AreRejectedOnSphere) { ExpectWrongLoopsAreFound(MakeSphere(20, 25)); }

TEST(WrongLoops, AreRejectedOnTorus) { ExpectWrongLoopsAreFound(MakeTorus(20, 25)); }

TEST(WrongLoops, AreRejectedInGrid) { ExpectWrongLoopsAreFound(MakeGrid(7)); }

TEST(WrongLoops, AreRejectedByEachKernelFromOdometry) {
  TrueGraph wrong = MakeGrid(5);
  const std::vector<std::size_t> planted = PlantWrongLoops(0.1, &wrong);
  for (const char* kernel : {"gnc", "dcs", "geman_mcclure", "cauchy", "auto"}) {
    PoseGraphOptions options;
    options.loop_robustness = kernel;
    options.start = "odometry";
    TrueGraph graph = wrong;
    const PoseGraphSummary summary = OptimizePoseGraph(options, &graph.graph);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << kernel;
    EXPECT_THAT(summary.outlier_edges, ::testing::IsSupersetOf(planted)) << kernel;
    EXPECT_LE(summary.outlier_edges.size(), planted.size() + 0.02 * summary.loop_count) << kernel;
    EXPECT_FALSE(TestFit(graph.graph, summary).doubtful) << kernel;
  }
}

// A threshold below the noise rejects most loops.
TEST(WrongLoops, MakeResultDoubtfulIfMostLoopsAreRejected) {
  TrueGraph grid = MakeGrid(4);
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  options.start = "odometry";
  options.max_loop_squared_error = 1e-6;
  const PoseGraphSummary summary = OptimizePoseGraph(options, &grid.graph);
  const PoseGraphFit fit = TestFit(grid.graph, summary);
  EXPECT_TRUE(fit.doubtful);
  EXPECT_THAT(fit.reason, ::testing::HasSubstr("rejected"));
}

TEST(WrongLoops, AreRejectedAlikeByEachBackend) {
  TrueGraph wrong = MakeTorus(12, 12);
  PlantWrongLoops(0.1, &wrong);
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  PoseGraphSummary expected;
  const double ate = OptimizedAte(wrong, options, &expected);
  for (const std::string& backend : SparseBackendNames()) {
    options.sparse_backend = backend;
    PoseGraphSummary summary;
    EXPECT_NEAR(OptimizedAte(wrong, options, &summary), ate, 1e-4 * ate) << backend;
    EXPECT_EQ(summary.outlier_edges, expected.outlier_edges) << backend;
    EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9 * expected.final_cost) << backend;
  }
}

TEST(WrongLoops, GncKeepsResultWithoutWrongLoops) {
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  options.max_loop_squared_error = 1e3;  // above all errors of noise
  const TrueGraph clean = MakeTorus(12, 12);
  PoseGraphSummary robust, plain;
  const double robust_ate = OptimizedAte(clean, options, &robust);
  EXPECT_NEAR(robust_ate, OptimizedAte(clean, {}, &plain), 1e-6 * robust_ate);
  EXPECT_TRUE(robust.outlier_edges.empty());
}

class LargePoseGraphs : public ::testing::TestWithParam<const char*> {
 protected:
  static TrueGraph Make(const std::string& shape) {
    if (shape == "sphere") return MakeSphere(316, 317);            // 100,172 poses
    return shape == "torus" ? MakeTorus(316, 317) : MakeGrid(20);  // 8,000 poses
  }
};

TEST_P(LargePoseGraphs, ConvergeToSameCostWithEachBackend) {
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
}  // namespace surfit::testing
