#include <ceres/autodiff_cost_function.h>
#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include "cost_functions/chordal_relative_pose.h"
#include "cost_functions/planar_relative_pose.h"
#include "cost_functions/relative_pose.h"
#include "optimization/pose_graph/optimize_pose_graph.h"
#include "surfit/optimization/pose_graph.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

Rigid3d PlanarPose(double x, double y, double angle) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())), {x, y, 0}};
}

// A circle that is walked twice in SE(2), with noisy measurements. Its poses are the odometry.
TrueGraph MakePlanarCircle(int count) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  TrueGraph graph;
  graph.graph.planar = true;
  for (int i = 0; i < count; ++i) {
    const double angle = 4 * M_PI * i / count;
    graph.truth.push_back(PlanarPose(5 * std::cos(angle), 5 * std::sin(angle), angle));
    graph.graph.poses.push_back({i, graph.truth.back(), false});
  }
  const auto add = [&](std::size_t a, std::size_t b) {
    PoseGraphEdge edge;
    edge.a = a, edge.b = b;
    const double turn = 0.01 * normal(rng), x = 0.02 * normal(rng), y = 0.03 * normal(rng);
    edge.a_from_b = PlanarPose(x, y, turn) * graph.truth[a].Inverse() * graph.truth[b];
    edge.information.setZero();
    edge.information.diagonal().segment<3>(2) << 1e4, 2500, 1 / 9e-4;
    edge.loop = b != a + 1;
    graph.graph.edges.push_back(edge);
  };
  for (int i = 0; i + 1 < count; ++i) add(i, i + 1);
  for (int i = 0; i < count / 2; i += 3) add(i, i + count / 2);
  ChainPosesOf(&graph.graph);
  return graph;
}

// The same measurements in SE(3), where tight information holds z, roll and pitch.
PoseGraph Lifted(PoseGraph graph) {
  graph.planar = false;
  for (PoseGraphEdge& edge : graph.edges) {
    for (const int i : {0, 1, 5}) edge.information(i, i) = 1e4;
  }
  return graph;
}

TEST(PlanarRelativePose, EqualsRelativePoseOfLiftedPoses) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int k = 0; k < 20; ++k) {
    const Rigid3d measured = PlanarPose(any(rng), any(rng), any(rng));
    PoseInformation information = PoseInformation::Zero();
    information.block<3, 3>(2, 2) << 4, 1, 0.5, 1, 3, 0.2, 0.5, 0.2, 2;
    const double a[] = {any(rng), any(rng), any(rng)}, b[] = {any(rng), any(rng), any(rng)};
    double lifted_a[kPoseSize], lifted_b[kPoseSize], expected[6], residuals[3];
    LiftPlanarPose(a, lifted_a);
    LiftPlanarPose(b, lifted_b);
    RelativePose(measured, information)(lifted_a, lifted_b, expected);
    PlanarRelativePose(measured, information)(a, b, residuals);
    const double cost = Eigen::Map<Eigen::Vector3d>(residuals).squaredNorm();
    EXPECT_NEAR(cost, (Eigen::Map<Eigen::Matrix<double, 6, 1>>(expected).squaredNorm()),
                1e-9 * (1 + cost));
  }
}

TEST(ChordalRelativePose, EqualsRelativePoseForSmallErrors) {
  std::mt19937_64 rng(8);
  const Rigid3d a = RandomPose(1, 2, &rng), b = RandomPose(1, 2, &rng);
  const Rigid3d measured = RandomPose(1e-3, 1e-3, &rng) * a.Inverse() * b;
  double block_a[kPoseSize], block_b[kPoseSize], expected[6], residuals[6];
  PoseToBlock(a, block_a);
  PoseToBlock(b, block_b);
  RelativePose(measured, PoseInformation::Identity())(block_a, block_b, expected);
  ChordalRelativePose(measured, PoseInformation::Identity())(block_a, block_b, residuals);
  // The difference is of second order in errors of 1e-3.
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(residuals[i], expected[i], 3e-6);
}

TEST(ChordalRelativePose, TranslationHasTheLengthOfRelativePose) {
  std::mt19937_64 rng(9);
  double block_a[kPoseSize], block_b[kPoseSize], expected[6], residuals[6];
  for (int trial = 0; trial < 20; ++trial) {
    PoseToBlock(RandomPose(2, 2, &rng), block_a);
    PoseToBlock(RandomPose(2, 2, &rng), block_b);
    const Rigid3d measured = RandomPose(2, 2, &rng);
    RelativePose(measured, PoseInformation::Identity())(block_a, block_b, expected);
    ChordalRelativePose(measured, PoseInformation::Identity())(block_a, block_b, residuals);
    EXPECT_NEAR(Eigen::Map<Eigen::Vector3d>(residuals + 3).norm(),
                Eigen::Map<Eigen::Vector3d>(expected + 3).norm(), 1e-12);
  }
}

// Rotation noise of 0.2 rad per pose turns the odometry around, as in noisy public spheres. The end
// is in the documented error, at the minimum that the chordal start finds.
TEST(OptimizePoseGraph, ReachesTheChordalMinimumFromBadOdometry) {
  TrueGraph sphere = MakeSphere(10, 20, {0.2, 0.5});
  PoseGraph graph = sphere.graph;
  const double best = OptimizePoseGraph({}, &graph).final_cost;
  PoseGraphOptions options;
  options.start = "odometry";
  const PoseGraphSummary summary = OptimizePoseGraph(options, &sphere.graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  EXPECT_EQ(summary.round_count, 2);  // start phase and end
  EXPECT_GT(summary.initial_cost, 100 * best);
  EXPECT_NEAR(summary.final_cost, best, 1e-6 * best);
  EXPECT_NEAR(summary.final_cost, Cost(sphere.graph), 1e-10 * summary.final_cost);
}

TEST(PlanarPoseGraph, HasMinimumOfLiftedGraph) {
  for (const std::string& start : PoseGraphStartNames()) {
    PoseGraphOptions options;
    options.start = start;
    PoseGraph planar = MakePlanarCircle(60).graph, lifted = Lifted(planar);
    const PoseGraphSummary expected = OptimizePoseGraph(options, &lifted);
    const PoseGraphSummary summary = OptimizePoseGraph(options, &planar);
    EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged) << start;
    EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-8 * expected.final_cost) << start;
    EXPECT_NEAR(summary.final_cost, Cost(planar), 1e-9 * summary.final_cost) << start;
    for (std::size_t i = 0; i < planar.poses.size(); ++i) {
      EXPECT_THAT(planar.poses[i].world_from_pose,
                  RigidNear(lifted.poses[i].world_from_pose, 1e-5, 1e-5));
    }
    planar.Validate();
    const PoseGraphFit fit = TestFit(planar, summary);
    const double freedom = 3. * (planar.edges.size() - planar.poses.size() + 1);
    EXPECT_EQ(fit.degrees_of_freedom, freedom);
    EXPECT_NEAR(fit.chi_square, freedom, 5 * std::sqrt(2 * freedom));
    EXPECT_FALSE(fit.doubtful) << fit.reason;
  }
}

TEST(PlanarPoseGraph, RejectsPosesOutsideOfPlane) {
  PoseGraph graph = MakePlanarCircle(12).graph;
  graph.poses[3].world_from_pose.translation.z() = 1;
  ExpectInputError([&] { graph.Validate(); }, Names(3, "SE(2)"));
  graph = MakePlanarCircle(12).graph;
  graph.edges[4].information(0, 0) = 1;
  ExpectInputError([&] { graph.Validate(); }, Names(4, 5, "SE(2)"));
}

TEST(SelectOdometry, JoinsNeighboursInTheOrderOfIds) {
  PoseGraph graph;
  for (const std::int64_t id : {30, 10, 20, 77}) graph.poses.push_back({id, {}, false});
  const auto add = [&](std::size_t a, std::size_t b) {
    graph.edges.emplace_back();
    graph.edges.back().a = a, graph.edges.back().b = b;
  };
  add(1, 2), add(0, 2), add(1, 0), add(3, 0);
  const auto loops = [&](const char* odometry) {
    SelectOdometry(odometry, &graph);
    std::vector<bool> marked;
    for (const PoseGraphEdge& edge : graph.edges) marked.push_back(edge.loop);
    return marked;
  };
  EXPECT_THAT(loops("consecutive"), ::testing::ElementsAre(false, false, true, false));
  EXPECT_THAT(loops("spanning_tree"), ::testing::ElementsAre(false, false, true, false));
  EXPECT_THAT(loops("none"), ::testing::Each(true));
  ExpectInputError([&] { SelectOdometry("some", &graph); }, Names("odometry", "some"));
}

// Exact priors move a graph of exact edges to the truth.
TEST(PoseGraphPriors, FixTheGauge) {
  TrueGraph exact = MakeSphere(3, 5);
  for (PoseGraphEdge& edge : exact.graph.edges) {
    edge.a_from_b = exact.truth[edge.a].Inverse() * exact.truth[edge.b];
  }
  for (PoseGraphPose& pose : exact.graph.poses) {
    pose.world_from_pose =
        Rigid3d(Eigen::Quaterniond(0.6, 0, 0.8, 0), {7, 8, 9}) * pose.world_from_pose;
  }
  PoseGraphPrior prior;
  prior.pose = 4;
  prior.pose_from_sensor = Rigid3d(Eigen::Quaterniond(0.8, 0.6, 0, 0), {0.1, 0.2, 0.3});
  prior.world_from_sensor = exact.truth[4] * prior.pose_from_sensor;
  PoseGraph with_pose = exact.graph, with_positions = exact.graph;
  with_pose.priors.push_back(prior);
  for (const std::size_t i : {1, 6, 9, 13}) {
    PoseGraphPosition position;
    position.pose = i;
    position.sensor_in_pose = {0, 0.5, 1};
    position.sensor_in_world = exact.truth[i] * position.sensor_in_pose;
    with_positions.positions.push_back(position);
  }
  for (PoseGraph* graph : {&with_pose, &with_positions}) {
    for (const std::string& start : PoseGraphStartNames()) {
      PoseGraphOptions options;
      options.start = start;
      PoseGraph solved = *graph;
      const PoseGraphSummary summary = OptimizePoseGraph(options, &solved);
      EXPECT_EQ(summary.held_count, 0u);
      EXPECT_NEAR(summary.final_cost, Cost(solved), 1e-9);
      for (std::size_t i = 0; i < exact.truth.size(); ++i) {
        EXPECT_THAT(solved.poses[i].world_from_pose, RigidNear(exact.truth[i], 1e-5, 1e-4))
            << start << " " << i;
      }
    }
  }
}

// Chains of two edges with variances s: the covariance of the end is 2 s along the chain.
TEST(MarginalCovariances, AddUpAlongAChain) {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) graph.poses.push_back({i, Rigid3d(), false});
  for (std::size_t i = 0; i < 2; ++i) {
    PoseGraphEdge edge;
    edge.a = i, edge.b = i + 1;
    edge.information.diagonal() << 100, 100, 100, 25, 25, 25;
    graph.edges.push_back(edge);
  }
  const PoseGraphSummary summary = OptimizePoseGraph({}, &graph);
  const auto covariances = MarginalCovariances(graph, summary, {0, 1, 2});
  ASSERT_TRUE(covariances);
  EXPECT_TRUE((*covariances)[0].isZero(0));
  Eigen::Matrix<double, 6, 1> variances;
  variances << 0.01, 0.01, 0.01, 0.04, 0.04, 0.04;
  EXPECT_LT(((*covariances)[1] - Eigen::Matrix<double, 6, 6>(variances.asDiagonal())).norm(), 1e-9);
  EXPECT_LT(((*covariances)[2].diagonal() - 2 * variances).norm(), 1e-9);
  ExpectInputError([&] { MarginalCovariances(graph, summary, {3}); }, Names(3));
  graph.edges[1].information(0, 0) = 0;
  EXPECT_FALSE(MarginalCovariances(graph, summary, {1}));
}

// Derivatives of the kernels agree with central differences.

using MatrixOfPose = Eigen::Matrix<double, 6, 6>;
using VectorOfPose = Eigen::Matrix<double, 6, 1>;

// The pose (exp(w) R, t + v) for the pose (R, t).
Rigid3d MovedInWorld(const Rigid3d& pose, const VectorOfPose& move) {
  return {QuaternionExp<double>(move.head<3>()) * pose.rotation, pose.translation + move.tail<3>()};
}

Eigen::VectorXd WhitenedErrors(const PoseGraph& graph) {
  Eigen::VectorXd errors(6 * graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseGraphEdge& edge = graph.edges[i];
    const Rigid3d error = graph.poses[edge.a].world_from_pose.Inverse() *
                          graph.poses[edge.b].world_from_pose * edge.a_from_b.Inverse();
    VectorOfPose e;
    e << QuaternionLog<double>(error.rotation), error.translation;
    errors.segment<6>(6 * static_cast<Eigen::Index>(i)) = edge.information.llt().matrixU() * e;
  }
  return errors;
}

TEST(MarginalCovariances, EqualTheDenseInverse) {
  PoseGraph graph = MakeSphere(3, 5).graph;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {  // full matrices
    VectorOfPose direction = VectorOfPose::LinSpaced(-1, 2);
    direction[i % 6] += 3;
    graph.edges[i].information += 2e3 * direction * direction.transpose();
  }
  const PoseGraphSummary summary = OptimizePoseGraph({}, &graph);
  const int count = static_cast<int>(graph.poses.size());
  Eigen::MatrixXd jacobian(6 * graph.edges.size(), 6 * (count - 1));
  constexpr double kStep = 1e-5;
  for (int column = 0; column < jacobian.cols(); ++column) {
    Rigid3d& pose = graph.poses[1 + column / 6].world_from_pose;
    const Rigid3d given = pose;
    const VectorOfPose move = kStep * VectorOfPose::Unit(column % 6);
    pose = MovedInWorld(given, move);
    const Eigen::VectorXd after = WhitenedErrors(graph);
    pose = MovedInWorld(given, -move);
    jacobian.col(column) = (after - WhitenedErrors(graph)) / (2 * kStep);
    pose = given;
  }
  const Eigen::MatrixXd dense = (jacobian.transpose() * jacobian).inverse();
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto covariances = MarginalCovariances(graph, summary, all);
  ASSERT_TRUE(covariances);
  for (int i = 1; i < count; ++i) {
    const MatrixOfPose expected = dense.block<6, 6>(6 * (i - 1), 6 * (i - 1));
    EXPECT_LT(((*covariances)[i] - expected).norm(), 1e-5 * expected.norm()) << i;
  }
}

// The squared Mahalanobis distance of the true pose is chi-square with 6 degrees of freedom. The
// mean over 60 draws has a standard deviation of sqrt(12 / 60).
TEST(MarginalCovariances, AgreeWithErrors) {
  constexpr int kDraws = 60;
  const std::vector<std::size_t> poses = {4, 9, 14};
  const GraphNoise noise{0.005, 0.01};
  TrueGraph graph = MakeSphere(3, 5);
  std::mt19937_64 rng(11);
  std::vector<double> sums(poses.size(), 0);
  for (int draw = 0; draw < kDraws; ++draw) {
    for (PoseGraphEdge& edge : graph.graph.edges) {
      edge = MeasuredEdge(graph, edge.a, edge.b, noise, &rng);
    }
    const PoseGraphSummary summary = OptimizePoseGraph({}, &graph.graph);
    const auto covariances = MarginalCovariances(graph.graph, summary, poses);
    ASSERT_TRUE(covariances);
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const Rigid3d& found = graph.graph.poses[poses[k]].world_from_pose;
      const Rigid3d& truth = graph.truth[poses[k]];
      VectorOfPose error;
      error << QuaternionLog<double>(truth.rotation * found.rotation.conjugate()),
          truth.translation - found.translation;
      sums[k] += error.dot((*covariances)[k].llt().solve(error)) / kDraws;
    }
  }
  EXPECT_THAT(sums, Each(::testing::DoubleNear(6, 4 * std::sqrt(12. / kDraws))));
}

TEST(LoopLoss, DerivativesAreThoseOfTheValue) {
  for (const auto kernel : {LoopRobustness::kDcs, LoopRobustness::kHuber, LoopRobustness::kCauchy,
                            LoopRobustness::kGemanMcClure}) {
    LoopLoss loss;
    loss.kernel = kernel;
    loss.max_squared_error = 10;
    for (const double s : {0.5, 9., 11., 200.}) {
      double at[3], below[3], above[3];
      const double step = 1e-4 * s;
      loss.Evaluate(s, at);
      loss.Evaluate(s - step, below);
      loss.Evaluate(s + step, above);
      EXPECT_NEAR(at[1], (above[0] - below[0]) / (2 * step), 1e-6);
      EXPECT_NEAR(at[2], (above[1] - below[1]) / (2 * step), 1e-6);
    }
  }
}

// A common factor of all information matrices is no reason for doubt.
TEST(TestFit, AcceptsUncalibratedInformation) {
  for (const double factor : {0.01, 1., 100.}) {
    PoseGraph graph = MakeGrid(4).graph;
    for (PoseGraphEdge& edge : graph.edges) edge.information *= factor;
    const PoseGraphSummary summary = OptimizePoseGraph({}, &graph);
    const PoseGraphFit fit = TestFit(graph, summary);
    EXPECT_FALSE(fit.doubtful) << fit.reason;
    EXPECT_NEAR(fit.odometry_ratio, factor, 0.3 * factor);
    EXPECT_NEAR(fit.loop_ratio, factor, 0.3 * factor);
  }
}

}  // namespace
}  // namespace surfit::testing
