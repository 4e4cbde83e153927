#include "surfit/optimization/optimize_pose_graph.h"

#include <gmock/gmock.h>

#include <thread>

#include "testing/expect_input_error.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::MakeGrid;
using testing::MakeSphere;
using testing::MakeTorus;
using testing::TrueGraph;

std::vector<double> Numbers(const PoseGraph& graph) {
  std::vector<double> numbers;
  for (const PoseGraphPose& pose : graph.poses) {
    for (const double q : pose.world_from_pose.rotation.coeffs()) numbers.push_back(q);
    for (const double t : pose.world_from_pose.translation) numbers.push_back(t);
  }
  return numbers;
}

TEST(OptimizePoseGraph, FindsTheTruthOfExactMeasurements) {
  TrueGraph exact = MakeSphere(6, 12);
  for (PoseGraphEdge& edge : exact.graph.edges) {
    edge.a_from_b = exact.truth[edge.a].Inverse() * exact.truth[edge.b];
  }
  for (const std::string& way : PoseGraphInitializationNames()) {
    PoseGraphOptions options;
    options.initialization = way;
    PoseGraph graph = exact.graph;
    const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << way;
    EXPECT_EQ(summary.held_count, 1u);
    for (std::size_t i = 0; i < exact.truth.size(); ++i) {
      EXPECT_THAT(graph.poses[i].world_from_pose, testing::RigidNear(exact.truth[i], 1e-6, 1e-8))
          << way << " " << i;
    }
  }
}

// Each measurement as two of rank 3, whose informations add up to its own.
PoseGraph SplitByDirection(const PoseGraph& graph) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  PoseGraph split = graph;
  split.edges.clear();
  for (const PoseGraphEdge& edge : graph.edges) {
    const Matrix6d root = edge.information.llt().matrixU();
    for (const int part : {0, 3}) {
      const Matrix6d half = root.middleRows<3>(part).transpose() * root.middleRows<3>(part);
      split.edges.push_back(edge);
      split.edges.back().information = (half + half.transpose()) / 2;
    }
  }
  return split;
}

TEST(OptimizePoseGraph, TakesMeasurementsOfSomeDirectionsOnly) {
  const PoseGraph whole = MakeSphere(20, 20).graph;
  for (const std::string& way : PoseGraphInitializationNames()) {
    PoseGraphOptions options;
    options.initialization = way;
    PoseGraph graph = whole, split = SplitByDirection(whole);
    const PoseGraphSummary expected = OptimizePoseGraph(options, &graph);
    const PoseGraphSummary summary = OptimizePoseGraph(options, &split);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << way;
    EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9 * expected.final_cost) << way;
    EXPECT_NEAR(summary.final_cost, Cost(split), 1e-10 * summary.final_cost) << way;
  }
}

// The cost at the truth is 1/2 chi-square of 6 a measurement; the minimum's has 6 a free pose less.
TEST(OptimizePoseGraph, CostIsThatOfTheNoise) {
  TrueGraph sphere = MakeSphere(20, 20);
  const PoseGraphSummary summary = OptimizePoseGraph({}, &sphere.graph);
  const double freedom = 6. * sphere.graph.edges.size() - 6. * (sphere.graph.poses.size() - 1);
  EXPECT_NEAR(2 * summary.final_cost, freedom, 5 * std::sqrt(2 * freedom));
  EXPECT_NEAR(summary.final_cost, Cost(sphere.graph), 1e-10 * summary.final_cost);
  EXPECT_GT(summary.given_cost, summary.final_cost);
}

TEST(OptimizePoseGraph, HoldsFixedPosesAndOneInEachOtherPart) {
  TrueGraph sphere = MakeSphere(6, 12);
  PoseGraph graph = sphere.graph;
  // A second part: the same again under other ids.
  const std::size_t count = graph.poses.size();
  for (const PoseGraphPose& pose : sphere.graph.poses) {
    graph.poses.push_back(pose);
    graph.poses.back().id += 1000;
  }
  for (PoseGraphEdge edge : sphere.graph.edges) {
    edge.a += count;
    edge.b += count;
    graph.edges.push_back(edge);
  }
  graph.poses[5].fixed = graph.poses[20].fixed = true;
  graph.poses[5].world_from_pose = sphere.truth[5];
  graph.poses[20].world_from_pose = sphere.truth[20];
  const PoseGraph before = graph;
  const PoseGraphSummary summary = OptimizePoseGraph({}, &graph);
  EXPECT_EQ(summary.held_count, 3u);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const bool held = i == 5 || i == 20 || i == count;
    EXPECT_EQ(held, graph.poses[i].world_from_pose.translation ==
                        before.poses[i].world_from_pose.translation)
        << i;
  }
}

TEST(OptimizePoseGraph, LeavesAPoseWithoutEdgesWhereItIs) {
  PoseGraph graph = MakeSphere(3, 5).graph;
  graph.poses.push_back({99, Rigid3d(Eigen::Quaterniond::Identity(), {1, 2, 3}), false});
  EXPECT_EQ(OptimizePoseGraph({}, &graph).held_count, 2u);
  EXPECT_EQ(graph.poses.back().world_from_pose.translation, Eigen::Vector3d(1, 2, 3));
}

TEST(OptimizePoseGraph, LeavesAGraphWhereAllIsHeld) {
  const PoseGraph given = MakeSphere(3, 5).graph;
  for (const std::string& backend : SparseBackendNames()) {
    PoseGraphOptions options;
    options.sparse_backend = backend;
    PoseGraph graph = given;
    for (PoseGraphPose& pose : graph.poses) pose.fixed = true;
    const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << backend;
    EXPECT_NEAR(summary.final_cost, summary.given_cost, 1e-12 * summary.given_cost) << backend;
    EXPECT_EQ(Numbers(graph), Numbers(given)) << backend;
  }
}

TEST(OptimizePoseGraph, SaysWhereIterationsAreUsedUp) {
  PoseGraph graph = MakeTorus(10, 10).graph;
  PoseGraphOptions options;
  options.max_iterations = 1;
  options.initialization = "odometry";
  const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kMaxIterations);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST(OptimizePoseGraph, RefusesImpossibleOptions) {
  const auto refuse = [](auto change, const char* message) {
    PoseGraphOptions options;
    change(&options);
    ExpectInputError([&] { options.Validate(); }, HasSubstr(message));
  };
  refuse([](auto* o) { o->sparse_backend = "dense"; }, "sparse_backend is 'dense', must be one of");
  refuse([](auto* o) { o->initialization = "x"; }, "initialization is 'x', must be one of");
  refuse([](auto* o) { o->loop_robustness = "x"; }, "loop_robustness is 'x', must be one of");
  refuse([](auto* o) { o->max_iterations = 0; }, "max_iterations is 0, must be at least 1");
  refuse([](auto* o) { o->max_loop_squared_error = 0; }, "max_loop_squared_error is 0");
  refuse([](auto* o) { o->min_relative_cost_change = -1; }, "min_relative_cost_change is -1");
}

// Each shape, both from odometry and by chordal initialisation, with every backend there is.
class PoseGraphShapes : public ::testing::TestWithParam<const char*> {
 protected:
  static TrueGraph Make(const std::string& shape) {
    if (shape == "sphere") return MakeSphere(25, 25);
    return shape == "torus" ? MakeTorus(30, 30) : MakeGrid(7);
  }
};

TEST_P(PoseGraphShapes, ConvergeToOneCostWhereverTheyStartAndWhateverSolves) {
  const TrueGraph given = Make(GetParam());
  std::vector<double> costs;
  for (const char* way : {"odometry", "chordal"}) {
    for (const std::string& backend : SparseBackendNames()) {
      PoseGraphOptions options;
      options.initialization = way;
      options.sparse_backend = backend;
      PoseGraph graph = given.graph;
      const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
      EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
      costs.push_back(summary.final_cost);
      EXPECT_NEAR(costs.back(), costs.front(), 1e-9 * costs.front()) << way << " " << backend;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, PoseGraphShapes, ::testing::Values("sphere", "torus", "grid"));

// Ceres must not take more threads than one, nor OpenMP below it.
TEST(PoseGraphThreads, GiveTheSameBitsAtTheSameTime) {
  const TrueGraph given = MakeTorus(12, 12);
  PoseGraph alone = given.graph;
  OptimizePoseGraph({}, &alone);
  std::vector<PoseGraph> graphs(4, given.graph);
  std::vector<std::thread> threads;
  for (PoseGraph& graph : graphs) threads.emplace_back([&] { OptimizePoseGraph({}, &graph); });
  for (std::thread& thread : threads) thread.join();
  for (const PoseGraph& graph : graphs) EXPECT_EQ(Numbers(graph), Numbers(alone));
}

}  // namespace
}  // namespace surfit
