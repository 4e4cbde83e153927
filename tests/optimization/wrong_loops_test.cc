#include <gmock/gmock.h>

#include <iostream>
#include <map>

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

// Walk in SE(2) along the streets of a grid, with loop closures at crossings. The
// information states 15 times the standard deviation of the errors. A third of the loop closures
// are wrong, as in place recognition with similar views: the relative position is small.
TrueGraph MakeStreetsWithWrongLoops(std::uint64_t seed, std::vector<std::size_t>* planted) {
  constexpr int kPoses = 1000, kBlock = 6, kBlocks = 4;
  constexpr double kUnderstated = 15, kWrong = 0.5;
  const GraphNoise noise{0.004, 0.02};
  std::mt19937_64 rng(seed);
  TrueGraph graph;
  int x = 0, y = 0, heading = 0;
  std::map<std::pair<int, int>, std::vector<std::size_t>> visits;
  const int steps[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  for (std::size_t i = 0; i < kPoses; ++i) {
    const auto stays = [&](int way) {
      const int u = x + steps[way][0], v = y + steps[way][1];
      return u >= 0 && v >= 0 && u <= kBlock * kBlocks && v <= kBlock * kBlocks;
    };
    if (x % kBlock == 0 && y % kBlock == 0) {
      const int before = heading;
      do {
        heading = static_cast<int>(rng() % 4);
      } while (!stays(heading) || heading == (before + 2) % 4);
    }
    graph.truth.emplace_back(
        Eigen::AngleAxisd(heading * M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
        Eigen::Vector3d(x, y, 0));
    visits[{x, y}].push_back(i);
    x += steps[heading][0], y += steps[heading][1];
  }
  const auto planar = [&](PoseGraphEdge edge, const Eigen::Vector3d& error) {
    Eigen::Matrix<double, 6, 1> left;
    left << 0, 0, error[2], error[0], error[1], 0;
    edge.a_from_b =
        LeftIncrement<double>(left, graph.truth[edge.a].Inverse() * graph.truth[edge.b]);
    edge.information.setZero();
    const double rotation = std::pow(kUnderstated * noise.rotation_rad, -2);
    const double translation = std::pow(kUnderstated * noise.translation_m, -2);
    edge.information.diagonal() << 0, 0, rotation, translation, translation, 0;
    return edge;
  };
  std::normal_distribution<double> normal;
  const auto add = [&](std::size_t a, std::size_t b, bool loop) {
    PoseGraphEdge edge;
    edge.a = a, edge.b = b, edge.loop = loop;
    const double v = noise.translation_m;
    graph.graph.edges.push_back(
        planar(edge, {v * normal(rng), v * normal(rng), noise.rotation_rad * normal(rng)}));
  };
  graph.graph.planar = true;
  graph.graph.poses.resize(kPoses);
  for (std::size_t i = 0; i < kPoses; ++i) graph.graph.poses[i].id = static_cast<std::int64_t>(i);
  for (std::size_t i = 1; i < kPoses; ++i) add(i - 1, i, false);
  std::size_t loops = 0;
  for (const auto& [place, poses] : visits) {
    for (std::size_t k = 1; k < poses.size(); ++k) {
      if (place.first % kBlock == 0 && place.second % kBlock == 0)
        add(poses[k - 1], poses[k], true), ++loops;
    }
  }
  std::uniform_real_distribution<double> angle(-M_PI, M_PI);
  while (planted->size() < kWrong * loops) {
    const auto [a, b] = std::minmax({rng() % kPoses, rng() % kPoses});
    if (b < a + 10) continue;
    PoseGraphEdge edge = graph.graph.edges.back();
    edge.a = a, edge.b = b;
    edge.a_from_b =
        Rigid3d(Eigen::AngleAxisd(angle(rng), Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                Eigen::Vector3d(0.5 * normal(rng), 0.5 * normal(rng), 0));
    planted->push_back(graph.graph.edges.size());
    graph.graph.edges.push_back(edge);
  }
  return graph;
}

// The truncated cost with the stated information prefers wrong loop closures that bend the
// odometry.
TEST(WrongLoops, AreRejectedIfInformationUnderstatesAccuracy) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    std::vector<std::size_t> planted;
    TrueGraph graph = MakeStreetsWithWrongLoops(seed, &planted);
    ASSERT_GT(planted.size(), 10u);
    PoseGraphOptions options;
    options.loop_robustness = "gnc";
    PoseGraphSummary summary;
    EXPECT_LT(OptimizedAte(graph, options, &summary), 0.2) << seed;
    EXPECT_EQ(summary.outlier_edges, planted) << seed;
    EXPECT_LT(summary.loop_error_limit, 0.1 * options.max_loop_squared_error) << seed;
  }
}

// Straight walk in SE(2) whose errors are 0.3 of the stated standard deviation. Loop closures
// connect the first half. The last edge, a loop closure over 49 exact edges, is 1.4 m too long.
PoseGraph MakeLongChain() {
  constexpr double kSigma = 0.1, kRotationSigma = 1e-3;
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal(0, 0.3);
  PoseGraph graph;
  graph.planar = true;
  graph.poses.resize(100);
  for (std::size_t i = 0; i < 100; ++i) graph.poses[i].id = static_cast<std::int64_t>(i);
  const auto add = [&](std::size_t a, std::size_t b, double scale, double extra_m) {
    Eigen::Matrix<double, 6, 1> left = Eigen::Matrix<double, 6, 1>::Zero();
    left[2] = scale * kRotationSigma * normal(rng);
    left[3] = scale * kSigma * normal(rng);
    left[4] = scale * kSigma * normal(rng);
    PoseGraphEdge edge;
    edge.a = a, edge.b = b, edge.loop = b != a + 1;
    edge.a_from_b = LeftIncrement<double>(
        left, Rigid3d(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1. * (b - a) + extra_m, 0, 0)));
    const double rotation = std::pow(kRotationSigma, -2), translation = std::pow(kSigma, -2);
    edge.information.setZero();
    edge.information.diagonal() << 0, 0, rotation, translation, translation, 0;
    graph.edges.push_back(edge);
  };
  for (std::size_t i = 0; i < 99; ++i) add(i, i + 1, i < 50 ? 1 : 0, 0);
  for (std::size_t i = 0; i < 45; ++i) add(i, i + 5, 1, 0);
  add(50, 99, 0, 1.4);
  return graph;
}

// The squared error of the last loop closure is 196 if it is rejected. It adds 2 to the cost if it
// is accepted, because the 49 edges share the error.
TEST(WrongLoops, GncAcceptsCorrectLoopOfLongChain) {
  PoseGraph graph = MakeLongChain();
  PoseGraphOptions options;
  options.loop_robustness = "gnc";
  const PoseGraphSummary summary = OptimizePoseGraph(options, &graph);
  EXPECT_EQ(summary.termination, PoseGraphTermination::kConverged);
  EXPECT_TRUE(summary.outlier_edges.empty());
  EXPECT_LT(SquaredError(graph, graph.edges.back()), 1);
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
