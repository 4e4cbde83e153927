#include "common/icp_flags.h"

#include <gflags/gflags.h>

#include <array>
#include <charconv>
#include <string>

namespace {

const surfit::IcpOptions kIcp;
constexpr double kDegree = 3.14159265358979323846 / 180;

std::string TextOf(const std::string& text) { return text; }
std::string TextOf(bool value) { return value ? "true" : "false"; }

// The shortest text that gives the same number again.
template <typename Number>
std::string TextOf(Number value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace

DEFINE_int32(max_iterations, kIcp.max_iterations, "ICP iterations on each level at most");
DEFINE_double(max_distance_m, kIcp.gates.max_distance_m,
              "pairs farther apart are no pairs, on the finest level; 0 = off");
DEFINE_double(max_normal_angle_deg, kIcp.gates.max_normal_angle_rad / kDegree,
              "pairs whose normals differ by more are no pairs; 0 = off");
DEFINE_double(gate_growth, kIcp.gate_growth,
              "max_distance_m grows by this factor on each coarser level");
DEFINE_bool(middle_levels, kIcp.middle_levels,
            "register on all levels; false = on the coarsest and the finest only");
DEFINE_string(kernel, surfit::ToString(kIcp.error_model.kernel.type),
              "robust kernel: none, huber, tukey, geman_mcclure or student_t");
DEFINE_double(kernel_width, kIcp.error_model.kernel.width, "width of the robust kernel in sigmas");
DEFINE_bool(estimate_scale, kIcp.error_model.estimate_scale,
            "measure kernel_width in sigmas estimated from the residuals (MAD) before each solve, "
            "not in those of the noise model");
DEFINE_double(kernel_growth, kIcp.kernel_growth,
              "kernel_width grows by this factor on each coarser level");
DEFINE_double(floor_sigma_m, kIcp.error_model.floor_sigma_m,
              "standard deviation of a residual beyond the depth noise, m");
DEFINE_double(inverse_depth_sigma, kIcp.error_model.noise.inverse_depth_sigma,
              "depth noise: standard deviation of inverse depth, 1/m");
DEFINE_double(min_relative_rmse_change, kIcp.min_relative_rmse_change,
              "a level ends where RMSE changes by a smaller share");
DEFINE_bool(stop_at_rmse_increase, kIcp.stop_at_rmse_increase,
            "a level ends at the pose before where RMSE rises by more and inliers do not");
DEFINE_double(min_eigenvalue, kIcp.held.min_eigenvalue,
              "directions of motion that the data holds with no larger eigenvalue, from 0 to 1, "
              "are left alone");
DEFINE_double(min_information_ratio, kIcp.held.min_information_ratio,
              "and those it holds with less than so many times what noise of the normals feigns; "
              "0 = off");
DEFINE_int32(min_inliers, kIcp.min_inliers, "fewer pairs are a failure");

namespace surfit::tools {

void SetIcpFlagDefaults(const IcpOptions& options) {
  const auto set = [](const char* flag, const auto& value) {
    gflags::SetCommandLineOptionWithMode(flag, TextOf(value).c_str(), gflags::SET_FLAGS_DEFAULT);
  };
  set("residual", options.residual);
  set("association", options.association);
  set("max_iterations", options.max_iterations);
  set("max_distance_m", options.gates.max_distance_m);
  set("max_normal_angle_deg", options.gates.max_normal_angle_rad / kDegree);
  set("gate_growth", options.gate_growth);
  set("middle_levels", options.middle_levels);
  set("kernel_growth", options.kernel_growth);
  set("min_coarse_step_px", options.min_coarse_step_px);
  set("max_free_space_share", options.max_free_space_share);
  set("min_eigenvalue", options.held.min_eigenvalue);
  set("min_information_ratio", options.held.min_information_ratio);
}

IcpOptions IcpOptionsFromFlags(const IcpOptions& base) {
  IcpOptions options = base;
  options.max_iterations = FLAGS_max_iterations;
  options.gates.max_distance_m = FLAGS_max_distance_m;
  options.gates.max_normal_angle_rad = FLAGS_max_normal_angle_deg * kDegree;
  options.gate_growth = FLAGS_gate_growth;
  options.middle_levels = FLAGS_middle_levels;
  options.error_model.kernel = {RobustKernelTypeFromName(FLAGS_kernel), FLAGS_kernel_width};
  options.error_model.estimate_scale = FLAGS_estimate_scale;
  options.kernel_growth = FLAGS_kernel_growth;
  options.error_model.floor_sigma_m = FLAGS_floor_sigma_m;
  options.error_model.noise.inverse_depth_sigma = FLAGS_inverse_depth_sigma;
  options.min_relative_rmse_change = FLAGS_min_relative_rmse_change;
  options.stop_at_rmse_increase = FLAGS_stop_at_rmse_increase;
  options.held = {FLAGS_min_eigenvalue, FLAGS_min_information_ratio};
  options.min_inliers = FLAGS_min_inliers;
  return options;
}

}  // namespace surfit::tools
