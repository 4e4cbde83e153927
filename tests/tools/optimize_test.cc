#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "surfit/io/g2o.h"
#include "surfit/optimization/pose_graph.h"
#include "testing/matchers.h"
#include "testing/pose_graphs.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

TEST(OptimizeTool, RejectsOutlierLoopsAndWritesGraphAndSummary) {
  const TempFolder folder;
  TrueGraph torus = MakeTorus(10, 15);
  const auto planted = PlantWrongLoops(0.1, &torus);
  WriteG2o(torus.graph, folder / "in.g2o");
  WriteBytes(folder / "in.g2o", "SOMETHING 1\n" + ReadBytes(folder / "in.g2o"));
  const ProgramResult result = Succeeded(
      RunProgram("surfit_optimize",
                 {"--graph=" + folder / "in.g2o", "--loop_robustness=gnc",
                  "--output=" + folder / "out.g2o", "--summary=" + folder / "summary.json"}));
  EXPECT_THAT(result.out, Names("converged", 150, 1));
  EXPECT_THAT(result.err, Names(1, "SOMETHING"));
  const auto json = nlohmann::json::parse(ReadBytes(folder / "summary.json"));
  EXPECT_GE(json["wrong_loops"].size(), planted.size());
  EXPECT_EQ(json["options"]["loop_robustness"], "gnc");
  const PoseGraph written = ReadG2o(folder / "out.g2o").graph;
  double cost = 0;
  for (const PoseGraphEdge& edge : written.edges) {
    const double error = SquaredError(written, edge);
    if (!edge.loop || error <= PoseGraphOptions().max_loop_squared_error) cost += error / 2;
  }
  EXPECT_NEAR(json["final_cost"].get<double>(), cost, 1e-6 * cost);
}

TEST(OptimizeTool, ResultDoesNotDependOnThreadsOrBackend) {
  const TempFolder folder;
  WriteG2o(MakeSphere(20, 20).graph, folder / "in.g2o");
  std::vector<double> costs;
  for (const std::string& backend : SparseBackendNames()) {
    std::string first;
    for (const char* threads : {"1", "2", "7"}) {
      setenv("OMP_NUM_THREADS", threads, 1);
      setenv("OPENBLAS_NUM_THREADS", threads, 1);
      Succeeded(
          RunProgram("surfit_optimize",
                     {"--graph=" + folder / "in.g2o", "--linear_solver=" + backend,
                      "--output=" + folder / "out.g2o", "--summary=" + folder / "summary.json"}));
      const std::string bytes = ReadBytes(folder / "out.g2o");
      if (first.empty()) first = bytes;
      EXPECT_EQ(bytes, first) << backend << " " << threads;
    }
    const auto json = nlohmann::json::parse(ReadBytes(folder / "summary.json"));
    EXPECT_EQ(json["options"]["linear_solver"], backend);
    costs.push_back(json["final_cost"]);
    EXPECT_NEAR(costs.back(), costs.front(), 1e-9 * costs.front());
  }
  unsetenv("OMP_NUM_THREADS");
  unsetenv("OPENBLAS_NUM_THREADS");
}

TEST(OptimizeTool, ReportsMaxIterationsByTheExitCode) {
  const TempFolder folder;
  WriteG2o(MakeTorus(10, 15).graph, folder / "in.g2o");
  const ProgramResult result =
      RunProgram("surfit_optimize", {"--graph=" + folder / "in.g2o", "--start=odometry",
                                     "--max_graph_iterations=1", "--output=" + folder / "out.g2o"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, ::testing::HasSubstr("max_iterations"));
  EXPECT_THAT(result.err, Names("--max_graph_iterations"));
  EXPECT_EQ(ReadG2o(folder / "out.g2o").graph.poses.size(), 150u);
}

TEST(OptimizeTool, ReportsComponentsErrorsAndCovariances) {
  const TempFolder folder;
  PoseGraph graph = MakeGrid(3).graph;
  graph.poses.push_back({99, Rigid3d(), false});
  WriteG2o(graph, folder / "in.g2o");
  const ProgramResult result = Succeeded(RunProgram(
      "surfit_optimize",
      {"--graph=" + folder / "in.g2o", "--covariances=0,5", "--summary=" + folder / "summary.json",
       "--edge_errors=" + folder / "edges.csv", "--initialization=odometry"}));
  EXPECT_THAT(result.err, Names(2, 27));
  const auto json = nlohmann::json::parse(ReadBytes(folder / "summary.json"));
  EXPECT_EQ(json["options"]["start"], "odometry");
  EXPECT_EQ(json["covariances"].size(), 2u);
  EXPECT_EQ(json["covariances"]["0"][0], 0);
  EXPECT_GT(json["covariances"]["5"][0], 0);
  const std::string csv = ReadBytes(folder / "edges.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + static_cast<int>(graph.edges.size()));
  ExpectRefused(
      RunProgram("surfit_optimize", {"--graph=" + folder / "in.g2o", "--covariances=0,77"}),
      "--covariances", "77");
}

TEST(OptimizeTool, DoesNotOverwriteItsInput) {
  const TempFolder folder;
  WriteG2o(MakeGrid(3).graph, folder / "a.g2o");
  std::filesystem::create_hard_link(folder / "a.g2o", folder / "same.g2o");
  const std::string before = ReadBytes(folder / "a.g2o");
  for (const char* flag : {"--output=", "--summary="}) {
    for (const char* name : {"a.g2o", "same.g2o"}) {
      ExpectRefused(
          RunProgram("surfit_optimize", {"--graph=" + folder / "a.g2o", flag + folder / name}),
          "--graph", folder / name);
    }
  }
  EXPECT_EQ(ReadBytes(folder / "a.g2o"), before);
}

TEST(OptimizeTool, ReportsAnUnwritableStdout) {
  const TempFolder folder;
  WriteG2o(MakeGrid(3).graph, folder / "a.g2o");
  const ProgramResult result =
      RunShell("$tools/surfit_optimize --graph=" + folder / "a.g2o" + " >/dev/full");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasError("stdout"));
}

TEST(OptimizeTool, RejectsBadInput) {
  EXPECT_EQ(RunProgram("surfit_optimize", {}).exit_code, 1);
  ExpectRefused(RunProgram("surfit_optimize", {"--graph=a", "--linear_solver=b"}),
                "--linear_solver", "b", "suite_sparse", "eigen_sparse");
}

}  // namespace
}  // namespace surfit::testing
