#include <gtest/gtest.h>

#include <functional>

#include "surfit/core/options.h"
#include "surfit/registration/icp.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

void ExpectRefused(const std::function<void(IcpOptions*)>& change, const char* message) {
  IcpOptions options;
  change(&options);
  ExpectInputError([&] { Validate(options); }, ::testing::StrEq(message));
  ExpectInputError([&] { Register({}, {}, Rigid3d(), options); }, ::testing::StrEq(message));
}

TEST(IcpOptions, DefaultsAreValid) { Validate(IcpOptions()); }

TEST(IcpOptions, UnknownNamesListTheKnown) {
  ExpectRefused([](auto* o) { o->solver = "magic"; },
                "solver is 'magic', must be one of: closed_form_ldlt, closed_form_lu, "
                "closed_form_qr, svd, ceres, ceres_per_point, tiny");
  // Then those follow that this process has registered.
  IcpOptions colour;
  colour.residual = "colour";
  ExpectInputError([&] { Validate(colour); },
                   ::testing::StartsWith("residual is 'colour', must be one of: point_to_point, "
                                         "point_to_plane, symmetric_point_to_plane, "
                                         "plane_to_plane"));
  ExpectRefused([](auto* o) { o->association = "guess"; },
                "association is 'guess', must be one of: projective, kd_tree");
}

TEST(IcpOptions, ImpossibleCombinationsSayWhatIsPossible) {
  ExpectRefused([](auto* o) { o->solver = "svd"; },
                "residual is 'point_to_plane', must be point_to_point with solver svd; all other "
                "solvers take every residual");
}

TEST(IcpOptions, ValidateNamesFieldValueAndConstraint) {
  ExpectRefused([](auto* o) { o->max_iterations = 0; },
                "max_iterations is 0, must be from 1 to 1000");
  ExpectRefused([](auto* o) { o->gate_growth = 0.5; }, "gate_growth is 0.5, must be at least 1");
  ExpectRefused([](auto* o) { o->kernel_growth = 0; }, "kernel_growth is 0, must be at least 1");
  ExpectRefused([](auto* o) { o->min_source_rows = -1; },
                "min_source_rows is -1, must be zero (all) or positive");
  ExpectRefused([](auto* o) { o->min_coarse_step_px = -1; },
                "min_coarse_step_px is -1, must be zero or positive");
  ExpectRefused([](auto* o) { o->min_relative_rmse_change = -1; },
                "min_relative_rmse_change is -1, must be zero or positive");
  ExpectRefused([](auto* o) { o->min_increment = std::nan(""); },
                "min_increment is nan, must be zero or positive");
  ExpectRefused([](auto* o) { o->min_inliers = 5; }, "min_inliers is 5, must be at least 6");
  ExpectRefused([](auto* o) { o->min_inlier_share = 1.5; },
                "min_inlier_share is 1.5, must be from 0 to 1");
  ExpectRefused([](auto* o) { o->held.min_eigenvalue = 1; },
                "held.min_eigenvalue is 1, must be zero or positive and below 1");
  ExpectRefused([](auto* o) { o->held.min_information_ratio = -1; },
                "held.min_information_ratio is -1, must be zero (off) or positive");
  ExpectRefused([](auto* o) { o->max_free_space_share = 1.1; },
                "max_free_space_share is 1.1, must be from 0 to 1");
  ExpectRefused([](auto* o) { o->gates.max_distance_m = -0.1; },
                "gates.max_distance_m is -0.1, must be zero (off) or positive");
  ExpectRefused([](auto* o) { o->error_model.floor_sigma_m = 0; },
                "error_model.floor_sigma_m is 0, must be positive");
  ExpectRefused([](auto* o) { o->error_model.kernel.width = 0; },
                "error_model.kernel.width is 0, must be positive");
}

TEST(Termination, HasAName) {
  EXPECT_EQ(ToString(Termination::kConverged), "converged");
  EXPECT_EQ(ToString(Termination::kRmseIncreased), "rmse_increased");
  EXPECT_EQ(ToString(Termination::kMaxIterations), "max_iterations");
  EXPECT_EQ(ToString(Termination::kTooFewInliers), "too_few_inliers");
  EXPECT_EQ(ToString(Termination::kSingularSystem), "singular_system");
  EXPECT_EQ(ToString(Termination::kFreeSpaceFilled), "free_space_filled");
}

}  // namespace
}  // namespace surfit::testing
