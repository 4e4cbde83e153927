#include <gtest/gtest.h>

#include <functional>

#include "surfit/core/options.h"
#include "surfit/registration/icp.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

template <typename... Parts>
void ExpectRefused(const std::function<void(IcpOptions*)>& change, const Parts&... names) {
  IcpOptions options;
  change(&options);
  ExpectInputError([&] { Validate(options); }, Names(names...));
  ExpectInputError([&] { Register({}, {}, Rigid3d(), options); }, Names(names...));
}

TEST(IcpOptions, DefaultsAreValid) { Validate(IcpOptions()); }

TEST(IcpOptions, RejectUnknownNamesAndListKnownNames) {
  ExpectRefused([](auto* o) { o->solver = "magic"; }, "solver", "magic", "closed_form_ldlt",
                "closed_form_lu", "closed_form_qr", "svd", "ceres", "ceres_per_point", "tiny");
  // Registered residuals of this process follow the built-in residuals.
  IcpOptions colour;
  colour.residual = "colour";
  ExpectInputError([&] { Validate(colour); },
                   Names("residual", "colour", "point_to_point", "point_to_plane",
                         "symmetric_point_to_plane", "plane_to_plane"));
  ExpectRefused([](auto* o) { o->association = "guess"; }, "association", "guess", "projective",
                "kd_tree");
}

TEST(IcpOptions, RejectSvdWithOtherResiduals) {
  ExpectRefused([](auto* o) { o->solver = "svd"; }, "residual", "point_to_plane", "point_to_point",
                "svd");
}

TEST(IcpOptions, ValidateRejectsInvalidFieldsByName) {
  ExpectRefused([](auto* o) { o->max_iterations = 0; }, "max_iterations", 0, 1, 1000);
  ExpectRefused([](auto* o) { o->gate_growth = 0.5; }, "gate_growth", 0.5, 1);
  ExpectRefused([](auto* o) { o->kernel_growth = 0; }, "kernel_growth", 0, 1);
  ExpectRefused([](auto* o) { o->min_source_rows = -1; }, "min_source_rows", -1);
  ExpectRefused([](auto* o) { o->min_coarse_step_px = -1; }, "min_coarse_step_px", -1);
  ExpectRefused([](auto* o) { o->min_relative_rmse_change = -1; }, "min_relative_rmse_change", -1);
  ExpectRefused([](auto* o) { o->min_increment = std::nan(""); }, "min_increment", "nan");
  ExpectRefused([](auto* o) { o->min_inliers = 5; }, "min_inliers", 5, 6);
  ExpectRefused([](auto* o) { o->min_inlier_ratio = 1.5; }, "min_inlier_ratio", 1.5, 0, 1);
  ExpectRefused([](auto* o) { o->observability.min_eigenvalue = 1; },
                "observability.min_eigenvalue", 1, 1);
  ExpectRefused([](auto* o) { o->observability.min_information_ratio = -1; },
                "observability.min_information_ratio", -1);
  ExpectRefused([](auto* o) { o->max_free_space_violation_ratio = 1.1; },
                "max_free_space_violation_ratio", 1.1, 0, 1);
  ExpectRefused([](auto* o) { o->gates.max_distance_m = -0.1; }, "gates.max_distance_m", -0.1);
  ExpectRefused([](auto* o) { o->error_model.floor_sigma_m = 0; }, "error_model.floor_sigma_m", 0);
  ExpectRefused([](auto* o) { o->error_model.kernel.width = 0; }, "error_model.kernel.width", 0);
}

TEST(Termination, HasName) {
  EXPECT_EQ(ToString(Termination::kConverged), "converged");
  EXPECT_EQ(ToString(Termination::kRmseIncreased), "rmse_increased");
  EXPECT_EQ(ToString(Termination::kMaxIterations), "max_iterations");
  EXPECT_EQ(ToString(Termination::kTooFewInliers), "too_few_inliers");
  EXPECT_EQ(ToString(Termination::kSingularSystem), "singular_system");
  EXPECT_EQ(ToString(Termination::kFreeSpaceViolation), "free_space_violation");
}

}  // namespace
}  // namespace surfit::testing
