#include <gmock/gmock.h>

#include <random>

#include "apps/solvers/comparison_files.h"
#include "apps/solvers/pose_problem.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// A run with this error and time.
ComparedRun RunOf(double error_m, double total_ms, bool succeeded = true) {
  SolveOutcome outcome;
  outcome.target_from_source.translation.x() = error_m;
  outcome.succeeded = succeeded;
  outcome.termination = succeeded ? "converged" : "too_few_inliers";
  outcome.total_ms = total_ms;
  outcome.linearize_ms = total_ms / 10;
  outcome.points = 1000;
  outcome.iterations = 4;
  outcome.final_cost = 100 * error_m;
  return Compare(outcome, Rigid3d());
}

TEST(ComparisonRows, AreMediansOverTheRunsThatConverged) {
  ComparedRuns runs;
  runs.threads = 2;
  runs.runs = {RunOf(0.001, 10), RunOf(0.003, 30), RunOf(0.002, 20), RunOf(0.5, 1000),
               RunOf(0.001, 1000, false)};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.runs, 5);
  EXPECT_EQ(row.points, 1000);
  EXPECT_EQ(row.converged_ratio, 0.6);
  EXPECT_EQ(row.total_ms, 20);
  EXPECT_EQ(row.linearize_ms, 2);
  EXPECT_EQ(row.build_ms, std::nullopt);
  EXPECT_EQ(row.iterations, 4);
  EXPECT_EQ(row.translation_error_m, 0.002);
  EXPECT_EQ(row.rotation_error_deg, 0);
  EXPECT_EQ(row.final_cost, 0.2);
  EXPECT_EQ(row.termination, "converged");
}

TEST(ComparisonRows, HaveTimesOfFailuresIfNoRunConverged) {
  ComparedRuns runs;
  runs.runs = {RunOf(0.5, 10), RunOf(0.5, 30)};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.converged_ratio, 0);
  EXPECT_EQ(row.total_ms, 20);
  EXPECT_EQ(row.final_cost, std::nullopt);
  EXPECT_EQ(row.translation_error_m, std::nullopt);
}

TEST(ComparisonRows, HaveNoErrorsWithoutGroundTruth) {
  SolveOutcome outcome;
  outcome.succeeded = true;
  outcome.final_cost = 7;
  ComparedRuns runs;
  runs.runs = {Compare(outcome, std::nullopt)};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.converged_ratio, std::nullopt);
  EXPECT_EQ(row.translation_error_m, std::nullopt);
  EXPECT_EQ(row.final_cost, 7);
}

TEST(ComparisonRows, CountTheRunsOfACell) {
  ComparedRuns runs;
  runs.runs = {RunOf(0.001, 1), RunOf(0.5, 1), RunOf(0.5, 1)};
  runs.runs[2].cell = {1, 2};
  EXPECT_EQ(CountsOf(runs, {0, 0}).Ratio(), 0.5);
  EXPECT_EQ(CountsOf(runs, {1, 2}).Ratio(), 0);
  EXPECT_EQ(CountsOf(runs, {2, 1}).Ratio(), std::nullopt);
}

// The limits p solve (p - q)^2 = z^2 p (1 - p) / n for the ratio q, with z = 1.96.
TEST(WilsonInterval, ContainsTheProbabilitiesThatExplainTheRatio) {
  for (const RunCounts counts : {RunCounts{6, 4}, RunCounts{6, 0}, RunCounts{50, 49}}) {
    const auto [low, high] = WilsonInterval(counts);
    EXPECT_LE(low, *counts.Ratio() + 1e-12);
    EXPECT_GE(high, *counts.Ratio());
    for (const double p : {low, high}) {
      const double z = (p - *counts.Ratio()) / std::sqrt(p * (1 - p) / counts.runs);
      if (p > 1e-9) {
        EXPECT_NEAR(std::abs(z), 1.96, 1e-3) << counts.converged;
      }
    }
  }
  EXPECT_EQ(WilsonInterval({6, 0}).first, 0);
  EXPECT_EQ(WilsonInterval({6, 6}).second, 1);
  EXPECT_EQ(WilsonInterval({}), std::make_pair(0., 1.));
}

CompareOptions OnKnownPairs() {
  CompareOptions options;
  options.synthetic_points = 100;
  options.output = "out";
  return options;
}

CompareOptions OnSequence() {
  CompareOptions options;
  options.sequence.path = "folder";
  options.output = "out";
  return options;
}

std::vector<std::string> Titles(const CompareOptions& options) {
  std::vector<std::string> titles;
  for (const SolverCombination& combination : SolverCombinations(options)) {
    titles.push_back(combination.association + " " + combination.residual + " " +
                     combination.SolverTitle());
  }
  return titles;
}

// Five solvers and three linear solvers with four residuals, and svd with one residual.
TEST(SolverCombinations, OfKnownPairsAreAllValidCombinations) {
  const auto all = SolverCombinations(OnKnownPairs());
  EXPECT_EQ(all.size(), 33u);
  for (const SolverCombination& combination : all) {
    EXPECT_EQ(combination.association, "known");
    EXPECT_EQ(combination.linear_solver.empty(), !IsSlow(combination));
  }
}

TEST(SolverCombinations, OfSequencesExcludeTheSlowSolverByDefault) {
  CompareOptions options = OnSequence();
  EXPECT_EQ(SolverCombinations(options).size(), 2 * 21u);
  options.solvers = {"ceres_per_point"};
  options.linear_solvers = {"dense_normal_cholesky"};
  options.residuals = {"plane_to_plane"};
  options.associations = {"projective"};
  EXPECT_THAT(Titles(options),
              ElementsAre("projective plane_to_plane ceres_per_point (dense_normal_cholesky)"));
}

TEST(SolverCombinations, OfSvdAreItsSupportedCombinations) {
  CompareOptions options = OnKnownPairs();
  options.solvers = {"svd"};
  EXPECT_THAT(Titles(options), ElementsAre("known point_to_point svd"));
  options.solvers.clear();
  options.residuals = {"point_to_plane"};
  EXPECT_THAT(Titles(options), Not(::testing::Contains(Names("svd"))));
}

TEST(SolverCombinations, RejectUnknownNamesAndListKnownNames) {
  CompareOptions options = OnKnownPairs();
  options.solvers = {"ceres", "svd"};
  options.residuals = {"point_to_point", "plane_to_plane"};
  ExpectInputError([&] { Validate(options); },
                   Names("solvers", "svd", "residuals", "plane_to_plane", "point_to_point"));
  options = OnKnownPairs();
  options.solvers = {"magic"};
  ExpectInputError([&] { Validate(options); },
                   Names("solvers", "magic", "closed_form_ldlt", "ceres", "tiny"));
  options = OnKnownPairs();
  options.residuals = {"magic"};
  ExpectInputError([&] { Validate(options); },
                   Names("residuals", "magic", "symmetric_point_to_plane"));
  options = OnKnownPairs();
  options.linear_solvers = {"magic"};
  ExpectInputError([&] { Validate(options); },
                   Names("linear_solvers", "magic", "sparse_normal_cholesky"));
  options = OnKnownPairs();
  options.associations = {"kd_tree"};
  ExpectInputError([&] { Validate(options); }, Names("associations", "kd_tree"));
  options = OnSequence();
  options.associations = {"magic"};
  ExpectInputError([&] { Validate(options); },
                   Names("associations", "magic", "projective", "kd_tree"));
}

TEST(StartPoses, CellsCombineAllRotationsAndTranslations) {
  const std::vector<PerturbationCell> cells = AllCells(2, 3);
  ASSERT_EQ(cells.size(), 6u);
  EXPECT_EQ(cells[5].rotation, 1);
  EXPECT_EQ(cells[5].translation, 2);
  EXPECT_TRUE(cells[4].on_diagonal());
  EXPECT_FALSE(cells[5].on_diagonal());
}

TEST(StartPoses, DifferByTheGivenAngleAndDistance) {
  std::mt19937_64 rng(1);
  const Rigid3d pose = RandomPose(1, 1, &rng);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Rigid3d start = Perturbed(pose, 0.3, 0.2, seed);
    const Rigid3d motion = start * pose.Inverse();  // in the frame of the target
    EXPECT_NEAR(RotationAngle(motion.rotation), 0.3, 1e-12);
    EXPECT_NEAR(motion.translation.norm(), 0.2, 1e-12);
  }
}

TEST(StartPoses, DependOnlyOnTheSeed) {
  const Rigid3d once = Perturbed(Rigid3d(), 0.3, 0.2, 5), again = Perturbed(Rigid3d(), 0.3, 0.2, 5),
                other = Perturbed(Rigid3d(), 0.3, 0.2, 6);
  EXPECT_EQ(once.Matrix(), again.Matrix());
  EXPECT_NE(once.Matrix(), other.Matrix());
  // Perturbations with the same seed have the same direction.
  const Rigid3d farther = Perturbed(Rigid3d(), 0.3, 0.4, 5);
  EXPECT_LT((farther.translation - 2 * once.translation).norm(), 1e-12);
}

}  // namespace
}  // namespace surfit::testing
