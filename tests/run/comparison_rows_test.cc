#include "run/comparison_rows.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

// A run off by so many metres, that took so many milliseconds.
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
  return Compare(outcome, Rigid3d(), CompareOptions());
}

TEST(ComparisonRows, AreMediansOverTheRunsThatConverged) {
  ComparedRuns runs;
  runs.threads = 2;
  runs.runs = {RunOf(0.001, 10), RunOf(0.003, 30), RunOf(0.002, 20), RunOf(0.5, 1000),
               RunOf(0.001, 1000, false)};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.runs, 5);
  EXPECT_EQ(row.points, 1000);
  EXPECT_EQ(row.converged_share, 0.6);
  EXPECT_EQ(row.total_ms, 20);
  EXPECT_EQ(row.linearize_ms, 2);
  EXPECT_EQ(row.build_ms, std::nullopt);
  EXPECT_EQ(row.iterations, 4);
  EXPECT_EQ(row.translation_error_m, 0.002);
  EXPECT_EQ(row.rotation_error_deg, 0);
  EXPECT_EQ(row.final_cost, 0.2);
  EXPECT_EQ(row.termination, "converged");
}

TEST(ComparisonRows, SayWhatFailuresTookWhereNothingConverged) {
  ComparedRuns runs;
  runs.runs = {RunOf(0.5, 10), RunOf(0.5, 30)};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.converged_share, 0);
  EXPECT_EQ(row.total_ms, 20);
  EXPECT_EQ(row.final_cost, std::nullopt);
  EXPECT_EQ(row.translation_error_m, std::nullopt);
}

TEST(ComparisonRows, HaveNoErrorsWhereTheTruthIsUnknown) {
  SolveOutcome outcome;
  outcome.succeeded = true;
  outcome.final_cost = 7;
  ComparedRuns runs;
  runs.runs = {Compare(outcome, std::nullopt, CompareOptions())};
  const ComparisonRow row = RowOf(runs);
  EXPECT_EQ(row.converged_share, std::nullopt);
  EXPECT_EQ(row.translation_error_m, std::nullopt);
  EXPECT_EQ(row.final_cost, 7);
}

TEST(ComparisonRows, CountTheSharesOfACell) {
  ComparedRuns runs;
  runs.runs = {RunOf(0.001, 1), RunOf(0.5, 1), RunOf(0.5, 1)};
  runs.runs[2].cell = {1, 2};
  EXPECT_EQ(ConvergedShare(runs, {0, 0}), 0.5);
  EXPECT_EQ(ConvergedShare(runs, {1, 2}), 0);
  EXPECT_EQ(ConvergedShare(runs, {2, 1}), std::nullopt);
}

}  // namespace
}  // namespace surfit
