#include <cmath>

#include "core/named_values.h"
#include "registration/icp_level.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
}

}  // namespace

void ErrorModel::Validate() const {
  Require(noise.inverse_depth_sigma >= 0, "inverse_depth_sigma", noise.inverse_depth_sigma,
          "zero or positive");
  Require(std::isfinite(floor_sigma_m) && floor_sigma_m > 0, "floor_sigma_m", floor_sigma_m,
          "finite and positive");
  Require(kernel.width > 0, "kernel_width", kernel.width, "positive");
  Require(std::isfinite(photometric_weight) && photometric_weight >= 0, "photometric_weight",
          photometric_weight, "finite and zero (off) or positive");
  Require(std::isfinite(intensity_sigma) && intensity_sigma > 0, "intensity_sigma", intensity_sigma,
          "finite and positive");
  Require(intensity_kernel.width > 0, "intensity_kernel_width", intensity_kernel.width, "positive");
}

void HeldOptions::Validate() const {
  Require(min_eigenvalue >= 0 && min_eigenvalue < 1, "min_eigenvalue", min_eigenvalue,
          "zero or positive and below 1");
  Require(std::isfinite(min_information_ratio) && min_information_ratio >= 0,
          "min_information_ratio", min_information_ratio, "finite and zero (off) or positive");
}

void AssociationGates::Validate() const {
  Require(max_distance_m >= 0, "max_distance_m", max_distance_m, "zero (off) or positive");
  Require(max_normal_angle_rad >= 0 && max_normal_angle_rad < M_PI / 2, "max_normal_angle_rad",
          max_normal_angle_rad, "zero (off) or positive and below pi/2");
}

void IcpOptions::Validate() const {
  RequireName("linear_solver", linear_solver, LinearSolverNames());
  RequireName("association", association, AssociationNames());
  MakePoseSolver(SolverOptions(*this, error_model));  // throws where it is impossible
  Require(max_iterations >= 1 && max_iterations <= 1000, "max_iterations", max_iterations,
          "from 1 to 1000");
  gates.Validate();
  Require(gate_growth >= 1, "gate_growth", gate_growth, "at least 1");
  Require(kernel_growth >= 1, "kernel_growth", kernel_growth, "at least 1");
  error_model.Validate();
  Require(min_source_rows >= 0, "min_source_rows", min_source_rows, "zero (all) or positive");
  Require(min_coarse_step_px >= 0, "min_coarse_step_px", min_coarse_step_px, "zero or positive");
  Require(min_relative_rmse_change >= 0, "min_relative_rmse_change", min_relative_rmse_change,
          "zero or positive");
  Require(min_increment >= 0, "min_increment", min_increment, "zero or positive");
  Require(min_inliers >= 6, "min_inliers", min_inliers, "at least 6");
  Require(min_inlier_share >= 0 && min_inlier_share <= 1, "min_inlier_share", min_inlier_share,
          "from 0 to 1");
  held.Validate();
  Require(max_free_space_share >= 0 && max_free_space_share <= 1, "max_free_space_share",
          max_free_space_share, "from 0 to 1");
}

}  // namespace surfit
