#include <gmock/gmock.h>

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
                     {"--graph=" + folder / "in.g2o", "--sparse_backend=" + backend,
                      "--output=" + folder / "out.g2o", "--summary=" + folder / "summary.json"}));
      const std::string bytes = ReadBytes(folder / "out.g2o");
      if (first.empty()) first = bytes;
      EXPECT_EQ(bytes, first) << backend << " " << threads;
    }
    const auto json = nlohmann::json::parse(ReadBytes(folder / "summary.json"));
    EXPECT_EQ(json["options"]["sparse_backend"], backend);
    costs.push_back(json["final_cost"]);
    EXPECT_NEAR(costs.back(), costs.front(), 1e-9 * costs.front());
  }
  unsetenv("OMP_NUM_THREADS");
  unsetenv("OPENBLAS_NUM_THREADS");
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
  ExpectRefused(RunProgram("surfit_optimize", {"--graph=a", "--sparse_backend=b"}),
                "--sparse_backend", "b");
}

}  // namespace
}  // namespace surfit::testing
