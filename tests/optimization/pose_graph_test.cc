#include "surfit/optimization/pose_graph.h"

#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "optimization/pose_graph/optimize_pose_graph.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"

namespace surfit::testing {
namespace {

PoseGraph Small() { return MakeSphere(3, 5).graph; }

TEST(PoseGraph, CostOfOdometryAloneIsThatOfItsLoops) {
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

TEST(PoseGraph, RefusesImpossibleGraphs) {
  Small().Validate();
  PoseGraph graph = Small();
  graph.poses[3].id = 2;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("the id 2 of a pose must be unique"));
  graph = Small();
  graph.poses[3].world_from_pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("pose 3 must be finite"));
  graph = Small();
  graph.edges[1].b = 15;
  ExpectInputError([&] { graph.Validate(); },
                   HasSubstr("edge 1 joins poses 1 and 15, must be two of 15"));
  graph = Small();
  graph.edges[1].information(0, 0) *= -1;
  ExpectInputError([&] { graph.Validate(); },
                   HasSubstr("information of the edge between poses 1 and 2 must be"));
  graph = Small();
  graph.edges[1].information(0, 1) += 1;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("symmetric"));
  graph = Small();
  graph.edges[1].a_from_b.rotation.coeffs() *= 2;
  ExpectInputError([&] { graph.Validate(); }, HasSubstr("unit quaternion"));
}

TEST(LoopWeights, ThresholdIsAChiSquareQuantile) {
  // 6 degrees of freedom: P(x) = 1 - exp(-x/2) (1 + x/2 + x^2/8).
  const double half = PoseGraphOptions().max_loop_squared_error / 2;
  EXPECT_NEAR(1 - std::exp(-half) * (1 + half + half * half / 2), 0.999, 1e-8);
}

TEST(LoopWeights, LeaveAllAloneWhereAllFit) {
  LoopWeights weights(10, {1, 9.9, 0});
  EXPECT_THAT(weights.Update({1, 9.9, 0}), Each(1));
}

// With errors that stay, mu goes to infinity and the weights to [e^2 < c^2].
TEST(LoopWeights, EndAtTheTruncation) {
  const std::vector<double> errors = {0, 5, 9, 11, 20, 1e6};
  LoopWeights weights(10, errors);
  std::vector<double> w = weights.Update(errors);
  EXPECT_FALSE(AreBinary(w));
  for (int i = 0; i < 100; ++i) w = weights.Update(errors);
  EXPECT_THAT(w, ElementsAre(1, 1, 1, 0, 0, 0));
  EXPECT_TRUE(AreBinary(w));
}

// The weight is what minimises w e^2 + mu (1 - w) / (mu + w) c^2, eq. 7 of the paper.
TEST(LoopWeights, MinimiseTheSurrogate) {
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
      EXPECT_THAT(graph.poses[i].world_from_pose, RigidNear(exact.truth[i], 1e-6, 1e-8))
          << way << " " << i;
    }
  }
}

// Three measurements of one rotation: half turns about x, y and z, with weights 0.25, 0.35 and 0.4.
// Their mean is diag(-0.5, -0.3, -0.2), a mirror. The sum of weight * |R - R_i|^2 over rotations is
// least at the measurement of the largest weight. The mirror as a quaternion is the half turn about
// x.
TEST(ChordalPoses, ReturnRotationsIfTheLinearSolutionIsAMirror) {
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
  EXPECT_THAT(poses->at(1), RigidNear(graph.edges[2].a_from_b, 1e-9, 1e-9));
}

TEST(ChordalPoses, AreExactWhicheverPoseIsHeld) {
  TrueGraph exact = MakeSphere(3, 5);
  for (PoseGraphEdge& edge : exact.graph.edges) {
    edge.a_from_b = exact.truth[edge.a].Inverse() * exact.truth[edge.b];
  }
  const std::size_t count = exact.truth.size();
  for (const std::size_t held : {std::size_t{0}, count / 2, count - 1}) {
    PoseGraph graph = exact.graph;
    graph.poses[held].world_from_pose = exact.truth[held];
    std::vector<bool> is_held(count, false);
    is_held[held] = true;
    const auto poses = ChordalPoses(graph, is_held);
    ASSERT_TRUE(poses);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_THAT(poses->at(i), RigidNear(exact.truth[i], 1e-6, 1e-8)) << held << " " << i;
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
  const auto refuse = ExpectOptionsRefused<PoseGraphOptions>;
  refuse([](auto& o) { o.sparse_backend = "dense"; }, "sparse_backend is 'dense', must be one of");
  refuse([](auto& o) { o.initialization = "x"; }, "initialization is 'x', must be one of");
  refuse([](auto& o) { o.loop_robustness = "x"; }, "loop_robustness is 'x', must be one of");
  refuse([](auto& o) { o.max_iterations = 0; }, "max_iterations is 0, must be at least 1");
  refuse([](auto& o) { o.max_loop_squared_error = 0; }, "max_loop_squared_error is 0");
  refuse([](auto& o) { o.min_relative_cost_change = -1; }, "min_relative_cost_change is -1");
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
}  // namespace surfit::testing
