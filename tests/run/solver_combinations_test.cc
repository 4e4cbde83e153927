#include "run/solver_combinations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "surfit/core/options.h"
#include "testing/expect_input_error.h"

namespace surfit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

// Five solvers and three linear solvers over four residuals, and svd over one.
TEST(SolverCombinations, OfKnownPairsAreAllThatMakeSense) {
  const auto all = SolverCombinations(OnKnownPairs());
  EXPECT_EQ(all.size(), 33u);
  for (const SolverCombination& combination : all) {
    EXPECT_EQ(combination.association, "known");
    EXPECT_EQ(combination.linear_solver.empty(), !IsSlow(combination));
  }
}

TEST(SolverCombinations, OfSequencesLeaveTheSlowOneToThoseWhoAsk) {
  CompareOptions options = OnSequence();
  EXPECT_EQ(SolverCombinations(options).size(), 2 * 21u);
  options.solvers = {"ceres_per_point"};
  options.linear_solvers = {"dense_normal_cholesky"};
  options.residuals = {"plane_to_plane"};
  options.associations = {"projective"};
  EXPECT_THAT(
      Titles(options),
      ::testing::ElementsAre("projective plane_to_plane ceres_per_point (dense_normal_cholesky)"));
}

TEST(SolverCombinations, OfSvdAreThoseItTakes) {
  CompareOptions options = OnKnownPairs();
  options.solvers = {"svd"};
  EXPECT_THAT(Titles(options), ::testing::ElementsAre("known point_to_point svd"));
  options.solvers.clear();
  options.residuals = {"point_to_plane"};
  EXPECT_THAT(Titles(options), ::testing::Not(::testing::Contains(HasSubstr("svd"))));
}

TEST(SolverCombinations, ListWhatIsPossible) {
  CompareOptions options = OnKnownPairs();
  options.solvers = {"ceres", "svd"};
  options.residuals = {"point_to_point", "plane_to_plane"};
  testing::ExpectInputError(
      [&] { Validate(options); },
      AllOf(HasSubstr("solvers has 'svd'"), HasSubstr("residuals has 'plane_to_plane'"),
            HasSubstr("svd takes point_to_point only")));
  options = OnKnownPairs();
  options.solvers = {"magic"};
  testing::ExpectInputError([&] { Validate(options); },
                            AllOf(HasSubstr("solvers has 'magic'"), HasSubstr("closed_form_ldlt"),
                                  HasSubstr("ceres"), HasSubstr("tiny")));
  options = OnKnownPairs();
  options.residuals = {"magic"};
  testing::ExpectInputError(
      [&] { Validate(options); },
      AllOf(HasSubstr("residuals has 'magic'"), HasSubstr("symmetric_point_to_plane")));
  options = OnKnownPairs();
  options.linear_solvers = {"magic"};
  testing::ExpectInputError(
      [&] { Validate(options); },
      AllOf(HasSubstr("linear_solvers has 'magic'"), HasSubstr("sparse_normal_cholesky")));
  options = OnKnownPairs();
  options.associations = {"kd_tree"};
  testing::ExpectInputError([&] { Validate(options); }, HasSubstr("associations is kd_tree"));
  options = OnSequence();
  options.associations = {"magic"};
  testing::ExpectInputError([&] { Validate(options); }, AllOf(HasSubstr("associations has 'magic'"),
                                                              HasSubstr("projective, kd_tree")));
}

}  // namespace
}  // namespace surfit
