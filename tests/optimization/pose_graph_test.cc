#include "surfit/optimization/pose_graph.h"

#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "optimization/pose_graph/optimize_pose_graph.h"
#include "optimization/pose_graph/robust_loops.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"

namespace surfit::testing {
namespace {

PoseGraph Small() { return MakeSphere(3, 5).graph; }

TEST(PoseGraph, CostAtOdometryIsCostOfLoops) {
  const PoseGraph graph = Small();
  double loops = 0;
  for (const PoseGraphEdge& edge : graph.edges) {
    const double error = SquaredError(graph, edge);
    if (edge.loop) {
      loops += error / 2;
    } else {
      EXPECT_LT(error, 1e-15);
    }
  }
  EXPECT_GT(loops, 1);
  EXPECT_NEAR(Cost(graph), loops, 1e-12 * loops);
}

TEST(PoseGraph, RejectsInvalidGraphs) {
  Small().Validate();
  PoseGraph graph = Small();
  graph.poses[3].id = 2;
  ExpectInputError([&] { graph.Validate(); }, Names(2));
  graph = Small();
  graph.poses[3].world_from_pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
  ExpectInputError([&] { graph.Validate(); }, Names(3));
  graph = Small();
  graph.edges[1].b = 15;
  ExpectInputError([&] { graph.Validate(); }, Names(1, 15));
  graph = Small();
  graph.edges[1].information(0, 0) *= -1;
  ExpectInputError([&] { graph.Validate(); }, Names("information", 1, 2));
  graph = Small();
  graph.edges[1].information(0, 1) += 1;
  ExpectInputError([&] { graph.Validate(); }, Names("information", 1, 2));
  graph = Small();
  graph.edges[1].a_from_b.rotation.coeffs() *= 2;
  ExpectInputError([&] { graph.Validate(); }, Names(1, 2));
}

TEST(LoopWeights, ThresholdIsChiSquareQuantile) {
  // CDF of chi-square with 6 degrees of freedom: P(x) = 1 - exp(-x/2) (1 + x/2 + x^2/8).
  const double half = PoseGraphOptions().max_loop_squared_error / 2;
  EXPECT_NEAR(1 - std::exp(-half) * (1 + half + half * half / 2), 0.999, 1e-8);
}

TEST(LoopWeights, AreOneWithoutOutliers) {
  LoopWeights weights(10, {1, 9.9, 0});
  EXPECT_THAT(weights.Update({1, 9.9, 0}), Each(1));
}

// With constant errors, mu goes to infinity and the weights to [e^2 < c^2].
TEST(LoopWeights, ConvergeToTruncation) {
  const std::vector<double> errors = {0, 5, 9, 11, 20, 1e6};
  LoopWeights weights(10, errors);
  std::vector<double> w = weights.Update(errors);
  EXPECT_FALSE(AreBinary(w));
  for (int i = 0; i < 100; ++i) w = weights.Update(errors);
  EXPECT_THAT(w, ElementsAre(1, 1, 1, 0, 0, 0));
  EXPECT_TRUE(AreBinary(w));
}

// The weight minimises w e^2 + mu (1 - w) / (mu + w) c^2, equation 7 of the paper.
TEST(LoopWeights, MinimiseSurrogateCost) {
  const double limit = 10, largest = 30, mu = limit / (2 * largest - limit);
  for (double error = 1; error < 60; error += 2) {
    LoopWeights weights(limit, {largest});
    const double w = weights.Update({error})[0];
    const auto cost = [&](double x) { return x * error + mu * (1 - x) / (mu + x) * limit; };
    for (double x = 0; x <= 1; x += 0.01) {
      EXPECT_LE(cost(w), cost(x) + 1e-9) << error << " " << x;
    }
  }
}

std::vector<double> Numbers(const PoseGraph& graph) {
  std::vector<double> numbers;
  for (const PoseGraphPose& pose : graph.poses) {
    for (const double q : pose.world_from_pose.rotation.coeffs()) numbers.push_back(q);
    for (const double t : pose.world_from_pose.translation) numbers.push_back(t);
  }
  return numbers;
}

TEST(OptimizePoseGraph, RecoversTruthFromExactMeasurements) {
  TrueGraph exact = MakeSphere(6, 12);
  for (PoseGraphEdge& edge : exact.graph.edges) {
    edge.a_from_b = exact.truth[edge.a].Inverse() * exact.truth[edge.b];
  }
  for (const std::string& way : PoseGraphStartNames()) {
    PoseGraphOptions options;
    options.start = way;
    PoseGraph graph = exact.graph;
    const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << way;
    EXPECT_EQ(summary.held_count, 1u);
    for (std::size_t i = 0; i < exact.truth.size(); ++i) {
      EXPECT_THAT(graph.poses[i].world_from_pose, RigidNear(exact.truth[i], 1e-6, 1e-8))
          << way << " " << i;
    }
  }
}

// Three measurements of one rotation: half turns about x, y and z, with the weights 0.25, 0.35 and
// 0.4. Their mean is diag(-0.5, -0.3, -0.2), a reflection. The rotation with the smallest sum of
// weight * |R - R_i|^2 is the measurement of the largest weight. The reflection as a quaternion is
// the half turn about x.
TEST(ChordalPoses, AreRotationsIfLinearSolutionIsReflection) {
  PoseGraph graph;
  graph.poses.resize(2);
  const double weights[] = {0.25, 0.35, 0.4};
  for (int axis = 0; axis < 3; ++axis) {
    PoseGraphEdge edge;
    edge.a = 0;
    edge.b = 1;
    edge.a_from_b.rotation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::Unit(axis));
    edge.information = weights[axis] * decltype(edge.information)::Identity();
    graph.edges.push_back(edge);
  }
  const auto poses = ChordalPoses(graph, {true, false});
  ASSERT_TRUE(poses);
  EXPECT_THAT(poses->world_from_pose.at(1), RigidNear(graph.edges[2].a_from_b, 1e-9, 1e-9));
}

TEST(ChordalPoses, AreExactForAnyFixedPose) {
  TrueGraph exact = MakeSphere(3, 5);
  for (PoseGraphEdge& edge : exact.graph.edges) {
    edge.a_from_b = exact.truth[edge.a].Inverse() * exact.truth[edge.b];
  }
  const std::size_t count = exact.truth.size();
  for (const std::size_t held : {std::size_t{0}, count / 2, count - 1}) {
    PoseGraph graph = exact.graph;
    graph.poses[held].world_from_pose = exact.truth[held];
    std::vector<bool> has_pose(count, false);
    has_pose[held] = true;
    const auto poses = ChordalPoses(graph, has_pose);
    ASSERT_TRUE(poses);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_THAT(poses->world_from_pose.at(i), RigidNear(exact.truth[i], 1e-6, 1e-8))
          << held << " " << i;
    }
  }
}

// Splits each measurement into two of rank 3. Their information matrices add up to the matrix of
// the measurement.
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

TEST(OptimizePoseGraph, SupportsRankDeficientInformation) {
  const PoseGraph whole = MakeSphere(20, 20).graph;
  for (const std::string& way : PoseGraphStartNames()) {
    PoseGraphOptions options;
    options.start = way;
    PoseGraph graph = whole, split = SplitByDirection(whole);
    const PoseGraphSummary expected = OptimizePoseGraph(options, &graph);
    const PoseGraphSummary summary = OptimizePoseGraph(options, &split);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << way;
    EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9 * expected.final_cost) << way;
    EXPECT_NEAR(summary.final_cost, Cost(split), 1e-10 * summary.final_cost) << way;
  }
}

// The cost at the ground truth is chi-square / 2 with 6 degrees of freedom per measurement. The
// minimum has 6 less per free pose.
TEST(OptimizePoseGraph, FinalCostIsChiSquareOfNoise) {
  TrueGraph sphere = MakeSphere(20, 20);
  const PoseGraphSummary summary = OptimizePoseGraph({}, &sphere.graph);
  const double freedom = 6. * sphere.graph.edges.size() - 6. * (sphere.graph.poses.size() - 1);
  EXPECT_NEAR(2 * summary.final_cost, freedom, 5 * std::sqrt(2 * freedom));
  EXPECT_NEAR(summary.final_cost, Cost(sphere.graph), 1e-10 * summary.final_cost);
  EXPECT_GT(summary.given_cost, summary.final_cost);
}

// A pose that one edge ties by its position only has no rotation in the chordal system.
TEST(OptimizePoseGraph, SolvesPoseWithoutRotationInformation) {
  PoseGraph graph = MakeSphere(3, 5).graph;
  const double cost = OptimizePoseGraph({}, &graph).final_cost;
  PoseGraphEdge edge;
  edge.a = graph.poses.size();
  edge.b = 2;
  edge.a_from_b.translation = {-1, -2, -3};
  edge.information.topLeftCorner<3, 3>().setZero();
  graph.poses.push_back({99, Rigid3d(), false});
  graph.edges.push_back(edge);
  const PoseGraphSummary summary = OptimizePoseGraph({}, &graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  EXPECT_NEAR(summary.final_cost, cost, 1e-8 * cost);
  EXPECT_THAT(summary.undetermined_rotations, ElementsAre(edge.a));
  EXPECT_TRUE(summary.undetermined_positions.empty());
  const Rigid3d to_new =
      graph.poses[2].world_from_pose.Inverse() * graph.poses[edge.a].world_from_pose;
  EXPECT_LT((to_new.translation - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
}

TEST(OptimizePoseGraph, FixesOnePosePerComponentWithoutFixedPose) {
  TrueGraph sphere = MakeSphere(6, 12);
  PoseGraph graph = sphere.graph;
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
  EXPECT_THAT(summary.component_sizes, ElementsAre(count, count));
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const bool held = i == 5 || i == 20 || i == count;
    EXPECT_EQ(held, graph.poses[i].world_from_pose.translation ==
                        before.poses[i].world_from_pose.translation)
        << i;
  }
}

TEST(OptimizePoseGraph, KeepsPoseWithoutEdges) {
  PoseGraph graph = MakeSphere(3, 5).graph;
  graph.poses.push_back({99, Rigid3d(Eigen::Quaterniond::Identity(), {1, 2, 3}), false});
  EXPECT_EQ(OptimizePoseGraph({}, &graph).held_count, 2u);
  EXPECT_EQ(graph.poses.back().world_from_pose.translation, Eigen::Vector3d(1, 2, 3));
}

TEST(OptimizePoseGraph, KeepsGraphOfFixedPoses) {
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

TEST(OptimizePoseGraph, ReportsMaxIterations) {
  PoseGraph graph = MakeTorus(10, 10).graph;
  PoseGraphOptions options;
  options.max_iterations = 1;
  options.start = "odometry";
  const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kMaxIterations);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST(OptimizePoseGraph, RejectsInvalidOptions) {
  const auto refuse = ExpectOptionsRefused<PoseGraphOptions>;
  refuse([](auto& o) { o.sparse_backend = "dense"; }, "sparse_backend", "dense");
  refuse([](auto& o) { o.start = "x"; }, "start", "x");
  refuse([](auto& o) { o.loop_robustness = "x"; }, "loop_robustness", "x");
  refuse([](auto& o) { o.max_iterations = 0; }, "max_iterations", "0");
  refuse([](auto& o) { o.max_loop_squared_error = 0; }, "max_loop_squared_error", "0");
  refuse([](auto& o) { o.min_relative_cost_change = -1; }, "min_relative_cost_change", "-1");
}

// Each shape, from odometry and from chordal initialisation, with each sparse backend.
class PoseGraphShapes : public ::testing::TestWithParam<const char*> {
 protected:
  static TrueGraph Make(const std::string& shape) {
    if (shape == "sphere") return MakeSphere(25, 25);
    return shape == "torus" ? MakeTorus(30, 30) : MakeGrid(7);
  }
};

TEST_P(PoseGraphShapes, ConvergeToSameCostFromAnyInitializationWithAnyBackend) {
  const TrueGraph given = Make(GetParam());
  std::vector<double> costs;
  for (const char* way : {"odometry", "chordal"}) {
    for (const std::string& backend : SparseBackendNames()) {
      PoseGraphOptions options;
      options.start = way;
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

// Ceres and OpenMP must use one thread only.
TEST(PoseGraphThreads, ConcurrentRunsAreBitwiseIdentical) {
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
}  // namespace surfit::testing
