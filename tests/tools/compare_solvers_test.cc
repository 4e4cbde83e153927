#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "testing/matchers.h"
#include "testing/run_program.h"

namespace surfit::testing {
namespace {

class CompareTool : public ::testing::Test {
 protected:
  ProgramResult Compare(std::vector<std::string> flags) const {
    flags.push_back("--output=" + Output());
    return RunProgram("surfit_compare_solvers", flags);
  }
  std::string Output() const { return own_ / "out"; }
  nlohmann::json Rows() const {
    return nlohmann::json::parse(ReadBytes(Output() + "/comparison.json"))["rows"];
  }

  TempFolder own_;
};

TEST_F(CompareTool, ComparesAllSolversOverKnownPairs) {
  const ProgramResult result = Succeeded(
      Compare({"--synthetic_points=2000", "--rotations_deg=1,10", "--translations_m=0.01,0.1"}));
  EXPECT_THAT(result.out, Names("ceres_per_point", "sparse_normal_cholesky"));
  const nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 33u);
  for (const auto& row : rows) {
    SCOPED_TRACE(row.dump());
    const bool slow = row["solver"] == "ceres_per_point";
    EXPECT_EQ(row["runs"], slow ? 2 : 4);
    EXPECT_EQ(row["points"], 2000);
    EXPECT_EQ(row["converged_ratio"], 1);
    EXPECT_NEAR(row["converged_low"], slow ? 0.342 : 0.510, 1e-3);  // 95 % interval of Wilson
    EXPECT_EQ(row["converged_high"], 1);
    // Single precision rounds coordinates up to 6 m by 2.4e-7 m.
    EXPECT_LT(row["translation_error_m"], 1e-6);
    const bool builds = slow || row["solver"] == "ceres" || row["solver"] == "tiny";
    EXPECT_EQ(row["build_ms"].is_null(), !builds);
    EXPECT_GE(row["total_ms"], row["solve_ms"]);
    EXPECT_TRUE(row["termination"].is_null());
  }
  const std::string page = ReadBytes(Output() + "/comparison.html");
  EXPECT_THAT(page, AllOf(StartsWith("<!DOCTYPE html>"), Names("\"losses\":[")));
  std::istringstream csv(ReadBytes(Output() + "/comparison.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_THAT(line, StartsWith("solver,linear_solver,residual,association,points,threads,"));
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  EXPECT_EQ(lines, 33);
}

// Noise of 1 cm on 2000 points causes a pose error of 1 cm / sqrt(2000). The rotation error about
// the origin, 3 m away, adds a few times that. The error model has the standard deviation of the
// noise, so twice the cost is chi-square with 3 * 2000 - 6 degrees of freedom.
TEST_F(CompareTool, ErrorMatchesTheNoiseOverKnownPairs) {
  Succeeded(Compare({"--synthetic_points=2000,0.01", "--rotations_deg=5", "--translations_m=0.1",
                     "--solver=svd,closed_form_ldlt,ceres", "--residual=point_to_point",
                     "--threads=1,2"}));
  const nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 6u);
  for (const auto& row : rows) {
    EXPECT_GT(row["translation_error_m"], 1e-5);
    EXPECT_LT(row["translation_error_m"], 5 * 4 * 0.01 / std::sqrt(2000));
    // All solvers converge to the same minimum.
    EXPECT_NEAR(row["final_cost"], rows[0]["final_cost"],
                1e-5 * rows[0]["final_cost"].get<double>());
    EXPECT_NEAR(2 * row["final_cost"].get<double>(), 5994, 4 * std::sqrt(2 * 5994));
  }
  EXPECT_EQ(rows[0]["threads"], 1);
  EXPECT_EQ(rows[1]["threads"], 2);
}

// The covariances of planes rotate with the source points, so each solver must repeat its step.
// Each step keeps the covariances constant. The gradient of the final cost is therefore not zero,
// and the final cost is proportional to the remaining pose difference of 1e-6.
TEST_F(CompareTool, SolversFindTheSameMinimumOverKnownPairs) {
  Succeeded(
      Compare({"--synthetic_points=2000,0.01", "--rotations_deg=10", "--translations_m=0.1"}));
  std::map<std::string, double> cost_of;
  for (const auto& row : Rows()) {
    SCOPED_TRACE(row.dump());
    const double cost = row["final_cost"];
    const auto [first, is_new] = cost_of.emplace(row["residual"], cost);
    const double tolerance = row["residual"] == "plane_to_plane" ? 2e-5 : 1e-6;
    EXPECT_NEAR(cost, first->second, tolerance * cost);
  }
  EXPECT_EQ(cost_of.size(), 4u);
}

TEST_F(CompareTool, ComparesOverPairsOfFrames) {
  const std::string room = own_ / "room";
  Succeeded(RunProgram("surfit_simulate", {"--output=" + room, "--frames=6", "--downsample=4"}));
  Succeeded(Compare({"--sequence=" + room, "--pairs=2,2", "--rotations_deg=1,45",
                     "--translations_m=0.01,1", "--solver=closed_form_ldlt,ceres"}));
  const nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 2u * 4 * 2);
  for (const auto& row : rows) {
    SCOPED_TRACE(row.dump());
    EXPECT_EQ(row["runs"], 8);
    if (row["residual"] != "point_to_plane") continue;
    EXPECT_GE(row["converged_ratio"], 0.25);  // from 1 deg and 1 cm
    EXPECT_LT(row["converged_ratio"], 1);     // not from 45 deg and 1 m
    EXPECT_LT(row["translation_error_m"], 0.005);
    EXPECT_FALSE(row["termination"].is_null());
  }
}

TEST_F(CompareTool, ComparesSlamOverASequence) {
  const std::string room = own_ / "room";
  Succeeded(RunProgram("surfit_simulate", {"--output=" + room, "--frames=4", "--downsample=4"}));
  Succeeded(Compare({"--sequence=" + room, "--pairs=0", "--slam", "--solver=closed_form_ldlt,ceres",
                     "--residual=point_to_plane", "--association=projective"}));
  const auto json = nlohmann::json::parse(ReadBytes(Output() + "/comparison.json"));
  EXPECT_TRUE(json["rows"].empty());
  const auto& rows = json["slam"];
  ASSERT_EQ(rows.size(), 2u);
  for (const auto& row : rows) {
    SCOPED_TRACE(row.dump());
    EXPECT_EQ(row["frames"], 4);
    EXPECT_EQ(row["frames_lost"], 0);
    EXPECT_LT(row["ate_m"], 0.005);
    EXPECT_GT(row["shared_surface"], 0.95);
  }
  EXPECT_EQ(rows[0]["surface_distance_mean_m"], 0);  // compared with itself
  EXPECT_EQ(rows[0]["shared_surface"], 1);
  // Surfaces move by at most the difference of the poses, a fraction of a millimetre.
  EXPECT_GT(rows[1]["surface_distance_mean_m"], 0);
  EXPECT_LT(rows[1]["surface_distance_mean_m"], 0.001);
  EXPECT_THAT(ReadBytes(Output() + "/slam.csv"), StartsWith("solver,linear_solver,residual,"));
}

TEST_F(CompareTool, ComparesOverTwoClouds) {
  const std::string room = own_ / "room";
  Succeeded(RunProgram("surfit_simulate", {"--output=" + room, "--frames=1", "--downsample=4"}));
  Succeeded(RunProgram("surfit_slam",
                       {"--sequence=" + room, "--output=" + (own_ / "slam"), "--nopictures"}));
  const std::string cloud = own_ / "slam" + "/map.ply";
  const std::vector<std::string> flags = {"--source=" + cloud, "--target=" + cloud,
                                          "--solver=closed_form_ldlt", "--rotations_deg=1",
                                          "--translations_m=0.02"};
  Succeeded(Compare(flags));
  for (const auto& row : Rows()) {
    EXPECT_EQ(row["association"], "kd_tree");
    EXPECT_TRUE(row["converged_ratio"].is_null());
    EXPECT_TRUE(row["translation_error_m"].is_null());
    EXPECT_FALSE(row["final_cost"].is_null());
  }
  std::vector<std::string> with_truth = flags;
  with_truth.push_back("--truth=0,0,0,0,0,0,1");
  Succeeded(Compare(with_truth));
  for (const auto& row : Rows()) {
    SCOPED_TRACE(row.dump());
    if (row["residual"] == "point_to_point") continue;  // converges slowly along surfaces
    EXPECT_EQ(row["converged_ratio"], 1);
    EXPECT_LT(row["translation_error_m"], 0.005);
  }
  // A flag overrides the default for clouds.
  std::vector<std::string> strict = flags;
  strict.push_back("--max_distance_m=0.0001");
  Succeeded(Compare(strict));
  for (const auto& row : Rows()) EXPECT_EQ(row["termination"], "too_few_inliers");
}

// A maximum distance of 0.1 mm leaves too few correspondences.
TEST_F(CompareTool, ReplaysFailedRegistrations) {
  const std::string room = own_ / "room";
  Succeeded(RunProgram("surfit_simulate", {"--output=" + room, "--frames=3", "--downsample=4"}));
  const std::string lost = own_ / "lost", termination = "too_few_inliers";
  ASSERT_EQ(RunProgram("surfit_slam",
                       {"--sequence=" + room, "--output=" + (own_ / "slam"),
                        "--max_distance_m=0.0001", "--nopictures", "--dump_failures=" + lost})
                .exit_code,
            2);
  const ProgramResult result = Succeeded(Compare({"--replay=" + lost + "/frame-000001"}));
  EXPECT_THAT(result.out, Names(termination));
  const nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 42u);
  for (const auto& row : rows) {
    EXPECT_EQ(row["runs"], 1);
    EXPECT_TRUE(row["converged_ratio"].is_null());
    if (row["solver"] == "closed_form_ldlt" && row["residual"] == "point_to_plane" &&
        row["association"] == "projective") {
      EXPECT_EQ(row["termination"], termination);
    }
  }
}

// Geometric and photometric costs, solved by `reduced` and by Ceres with two linear solvers. The
// Huber kernel is convex: with other kernels a surfel can have several minima.
TEST_F(CompareTool, ComparesTheSolversOfRefinement) {
  const std::string room = own_ / "room", run = own_ / "slam";
  ASSERT_EQ(RunProgram("surfit_simulate", {"--output=" + room, "--frames=40", "--downsample=4"})
                .exit_code,
            0);
  ASSERT_EQ(RunProgram("surfit_slam", {"--sequence=" + room, "--output=" + run, "--nopictures"})
                .exit_code,
            0);
  const ProgramResult result = Compare({"--run=" + run, "--max_keyframes=5", "--kernel=huber"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json rows = Rows();
  ASSERT_EQ(rows.size(), 6u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto &row = rows[i], &first = rows[i - i % 3];
    SCOPED_TRACE(row.dump());
    EXPECT_EQ(row["solver"], i % 3 == 0 ? "reduced" : "ceres");
    EXPECT_EQ(row["residual"], i < 3 ? "planes" : "planes_and_textures");
    EXPECT_EQ(row["termination"], "converged");
    EXPECT_EQ(row["points"], first["points"]);
    EXPECT_GT(row["points"], 1000);
    EXPECT_GT(row["iterations"], 1);
    EXPECT_GT(row["iteration_ms"], 0);
    // Ceres stores the derivatives of each residual by pose, calibration and displacement.
    if (i % 3 != 0) {
      EXPECT_GT(row["memory_bytes"], 17 * sizeof(double) * row["points"].get<double>());
    }
    // The solvers stop when a step changes the cost by less than 1e-6, a few steps before the
    // minimum.
    const double cost = first["final_cost"];
    EXPECT_NEAR(row["final_cost"], cost, 2e-5 * cost);
  }
  EXPECT_GT(rows[3]["points"], rows[0]["points"]);
  EXPECT_THAT(ReadBytes(Output() + "/comparison.html"), Names("\"refinement\":true"));
}

TEST_F(CompareTool, RejectsBadInputInOneLine) {
  const RefusedFlags cases = {
      {{}, {"synthetic_points", "sequence", "source", "replay", "0"}},
      {{"--synthetic_points=10", "--sequence=x"}, {"2"}},
      {{"--synthetic_points=-5"}, {"synthetic_points", "-5"}},
      {{"--synthetic_points=10", "--solver=magic"}, {"solvers", "magic", "closed_form_ldlt"}},
      {{"--synthetic_points=10", "--solver=svd", "--residual=point_to_plane"}, {"point_to_point"}},
      {{"--synthetic_points=10", "--threads=two"}, {"threads", "two"}},
      {{"--synthetic_points=10", "--threads=0"}, {"threads", "0"}},
      {{"--synthetic_points=10", "--rotations_deg=1,x"}, {"rotations_deg", "1,x"}},
      {{"--synthetic_points=10", "--translations_m=-1"}, {"translations_m", "-1"}},
      {{"--sequence=nowhere"}, {"nowhere"}},
      {{"--source=a.ply"}, {"source", "target"}},
      {{"--source=a.ply", "--target=b.ply"}, {"a.ply"}},
      {{"--synthetic_points=10", "--truth=0,0,0,0,0,0,1"}, {"truth", "source"}},
      {{"--synthetic_points=10", "--slam"}, {"slam", "sequence"}},
      {{"--run=nowhere"}, {"nowhere/summary.json"}},
      {{"--replay=nowhere"}, {"nowhere/frame.json"}},
  };
  for (const auto& [flags, names] : cases) ExpectRefused(Compare(flags), NamesMatcher(names));
}

}  // namespace
}  // namespace surfit::testing
