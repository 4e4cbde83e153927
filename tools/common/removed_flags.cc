#include "common/removed_flags.h"

#include <array>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

struct RemovedFlag {
  const char *program, *flag, *replacement;  // without a program: in all programs
};

// Flags of version 0.1 and their replacements: a flag, camera.yaml, the default, or a field
// in C++.
// Version 0.3 drops this table.
constexpr std::array kRemovedFlags = {
    RemovedFlag{"surfit_align", "initialize", "--start"},
    RemovedFlag{"surfit_align", "source", "--source_frame"},
    RemovedFlag{"surfit_align", "target", "--target_frame"},
    RemovedFlag{"surfit_compare_solvers", "thread_counts", "--threads"},
    RemovedFlag{"surfit_evaluate", "frames", "--frame_list"},
    RemovedFlag{"surfit_evaluate", "max_angle_deg", "--revisit_angle_deg"},
    RemovedFlag{"surfit_evaluate", "max_distance_m", "--revisit_distance_m"},
    RemovedFlag{"surfit_evaluate", "min_gap", "--revisit_gap"},
    RemovedFlag{"surfit_evaluate", "pictures", "--view_pictures"},
    RemovedFlag{"surfit_optimize", "max_iterations", "--max_graph_iterations"},
    RemovedFlag{"surfit_compare_solvers", "associations", "--association"},
    RemovedFlag{"surfit_compare_solvers", "linear_solvers", "--linear_solver"},
    RemovedFlag{"surfit_compare_solvers", "residuals", "--residual"},
    RemovedFlag{"surfit_compare_solvers", "solvers", "--solver"},
    RemovedFlag{"surfit_compare_solvers", "max_rotation_error_deg", "the default"},
    RemovedFlag{"surfit_compare_solvers", "max_translation_error_m", "the default"},
    RemovedFlag{"surfit_batch", "memory_mb", "set-resources of --profile"},
    RemovedFlag{"surfit_batch", "minutes", "set-resources of --profile"},
    RemovedFlag{"surfit_convert", "compress_depth", "the default"},
    RemovedFlag{"surfit_mesh", "max_texture_frames", "TextureOptions::max_texture_frames"},
    RemovedFlag{"surfit_mesh", "min_sharpness", "TextureOptions::min_sharpness"},
    RemovedFlag{"surfit_mesh", "normal_noise_deg", "MeshOptions::normal_noise_rad"},
    RemovedFlag{"surfit_mesh", "seam_cost", "TextureOptions::seam_cost"},
    RemovedFlag{"surfit_mesh", "support_radii", "MeshOptions::support_radii"},
    RemovedFlag{"surfit_mesh", "trim_distance_m", "MeshOptions::trim_distance_m"},
    RemovedFlag{"surfit_optimize", "max_loop_squared_error",
                "PoseGraphOptions::max_loop_squared_error"},
    RemovedFlag{"surfit_optimize", "min_relative_cost_change",
                "PoseGraphOptions::min_relative_cost_change"},
    RemovedFlag{"surfit_record", "frames", "--last"},
    RemovedFlag{"surfit_record", "max_frames", "--last"},
    RemovedFlag{"surfit_record", "queue_capacity", "the default"},
    RemovedFlag{"surfit_refine", "cells_across", "RefinementOptions::cells_across"},
    RemovedFlag{"surfit_refine", "estimate_depth_field", "--fix=depth_field"},
    RemovedFlag{"surfit_refine", "estimate_depth_offset", "--fix=depth_offset"},
    RemovedFlag{"surfit_refine", "estimate_intrinsics", "--fix=intrinsics"},
    RemovedFlag{"surfit_refine", "estimate_readout", "--fix=readout"},
    RemovedFlag{"surfit_refine", "keyframe_rotation_deg", "the default"},
    RemovedFlag{"surfit_refine", "prior_aspect_relative_sigma", "prior in camera.yaml"},
    RemovedFlag{"surfit_refine", "prior_center_px", "prior in camera.yaml"},
    RemovedFlag{"surfit_refine", "prior_focal_relative_sigma", "prior in camera.yaml"},
    RemovedFlag{"surfit_refine", "prior_inverse_depth", "prior in camera.yaml"},
    RemovedFlag{"surfit_refine", "prior_readout_s", "prior in camera.yaml"},
    RemovedFlag{"surfit_register", "levels", "RegisterCloudsOptions::levels"},
    RemovedFlag{"surfit_register", "normal_radius_m", "CloudNormalOptions::radius_m"},
    RemovedFlag{"surfit_register", "reciprocal", "RegisterCloudsOptions::reciprocal"},
    RemovedFlag{"surfit_report", "max_points", "the default"},
    RemovedFlag{"surfit_scan", "margin_m", "the default"},
    RemovedFlag{"surfit_scan", "max_index_bytes", "the default"},
    RemovedFlag{"surfit_scan", "max_similar", "the default"},
    RemovedFlag{"surfit_scan", "min_gap", "the default"},
    RemovedFlag{"surfit_simulate", "join", "--part=join/N"},
    RemovedFlag{"surfit_simulate", "parts", "--part=I/N"},
    RemovedFlag{"surfit_simulate", "exposure_samples", "ColorOptions::exposure_samples"},
    RemovedFlag{"surfit_simulate", "inverse_depth_offset",
                "--sensor_settings=inverse_depth_offset=VALUE"},
    RemovedFlag{"surfit_simulate", "inverse_depth_distortion",
                "--sensor_settings=inverse_depth_distortion=VALUE"},
    RemovedFlag{"surfit_simulate", "latency_s", "--sensor_settings=latency_s=VALUE"},
    RemovedFlag{"surfit_simulate", "color_latency_s", "--sensor_settings=color_latency_s=VALUE"},
    RemovedFlag{"surfit_simulate", "readout_s", "--sensor_settings=readout_s=VALUE"},
    RemovedFlag{"surfit_simulate", "color_readout_s", "--sensor_settings=color_readout_s=VALUE"},
    RemovedFlag{"surfit_simulate", "exposure_s", "--sensor_settings=exposure_s=VALUE"},
    RemovedFlag{"surfit_simulate", "auto_exposure_lag_s",
                "--sensor_settings=auto_exposure_lag_s=VALUE"},
    RemovedFlag{"surfit_simulate", "auto_white_balance_lag_s",
                "--sensor_settings=auto_white_balance_lag_s=VALUE"},
    RemovedFlag{"surfit_simulate", "channel_gains", "--sensor_settings=channel_gains=VALUE"},
    RemovedFlag{"surfit_simulate", "camera_yaml_focal_error",
                "--sensor_settings=camera_yaml_focal_error=VALUE"},
    RemovedFlag{"surfit_simulate", "camera_yaml_center_error",
                "--sensor_settings=camera_yaml_center_error=VALUE"},
    RemovedFlag{"surfit_simulate", "camera_yaml_times",
                "--sensor_settings=camera_yaml_times=VALUE"},
    RemovedFlag{"surfit_simulate", "imu_rate_hz", "--sensor_settings=imu_rate_hz=VALUE"},
    RemovedFlag{"surfit_simulate", "camera_from_imu", "--sensor_settings=camera_from_imu=VALUE"},
    RemovedFlag{"surfit_simulate", "imu_time_offset_s",
                "--sensor_settings=imu_time_offset_s=VALUE"},
    RemovedFlag{"surfit_simulate", "camera_yaml_imu", "--sensor_settings=camera_yaml_imu=VALUE"},
    RemovedFlag{"surfit_simulate", "write_imu", "--imu"},
    RemovedFlag{"surfit_simulate", "image_y_up", "--format=icl_nuim"},
    RemovedFlag{"surfit_simulate", "width", "--size"},
    RemovedFlag{"surfit_simulate", "height", "--size"},
    RemovedFlag{"surfit_simulate", "min_step_m", "--step_m"},
    RemovedFlag{"surfit_simulate", "max_step_m", "--step_m"},
    RemovedFlag{"surfit_refine", "refinement_linear_solver", "--linear_solver"},
    RemovedFlag{"surfit_refine", "refinement_solver", "--solver"},
    RemovedFlag{"", "active_frames", "FusionOptions::active_frames"},
    RemovedFlag{"", "angular_acceleration_rad_per_s2",
                "SlamOptions::angular_acceleration_rad_per_s2"},
    RemovedFlag{"", "color_distortion", "color_camera in camera.yaml"},
    RemovedFlag{"", "color_from_depth", "color_from_depth in camera.yaml"},
    RemovedFlag{"", "color_intrinsics", "color_camera in camera.yaml"},
    RemovedFlag{"", "color_latency_s", "color_latency_s in camera.yaml"},
    RemovedFlag{"", "confident_inlier_ratio", "SlamOptions::confident_inlier_ratio"},
    RemovedFlag{"", "depth_filter_radius", "PreprocessOptions::filter_radius_px"},
    RemovedFlag{"", "device_fps", "--device"},
    RemovedFlag{"", "device_height", "--device"},
    RemovedFlag{"", "device_lock_exposure", "--device"},
    RemovedFlag{"", "device_registration", "--device"},
    RemovedFlag{"", "device_width", "--device"},
    RemovedFlag{"", "distortion", "depth_camera in camera.yaml"},
    RemovedFlag{"", "duplicate_ratio", "FusionOptions::duplicate_ratio"},
    RemovedFlag{"", "estimate_scale", "ErrorModel::estimate_scale"},
    RemovedFlag{"", "floor_sigma_m", "ErrorModel::floor_sigma_m"},
    RemovedFlag{"", "fps", "frames_per_second in camera.yaml"},
    RemovedFlag{"", "free_space_margin_m", "FusionOptions::free_space_margin_m"},
    RemovedFlag{"", "initialize", "SlamOptions::initialize"},
    RemovedFlag{"", "intensity_sigma", "ErrorModel::intensity_sigma"},
    RemovedFlag{"", "kernel_width", "RobustKernel::width"},
    RemovedFlag{"", "latency_s", "latency_s in camera.yaml"},
    RemovedFlag{"", "max_free_space_violation_ratio", "IcpOptions::max_free_space_violation_ratio"},
    RemovedFlag{"", "max_inactive_frames", "FusionOptions::max_inactive_frames"},
    RemovedFlag{"", "max_iterations", "IcpOptions::max_iterations"},
    RemovedFlag{"", "max_rmse_m", "SlamOptions::max_rmse_m"},
    RemovedFlag{"", "linear_solver", "IcpOptions::linear_solver"},
    RemovedFlag{"", "max_view_shift", "SlamOptions::max_view_shift"},
    RemovedFlag{"", "merge_angle_deg", "FusionOptions::merge_angle_rad"},
    RemovedFlag{"", "merge_distance_m", "FusionOptions::merge_distance_m"},
    RemovedFlag{"", "min_eigenvalue", "ObservabilityOptions::min_eigenvalue"},
    RemovedFlag{"", "min_inactive_confidence", "FusionOptions::min_inactive_confidence"},
    RemovedFlag{"", "min_inlier_ratio", "SlamOptions::min_inlier_ratio"},
    RemovedFlag{"", "min_inliers", "IcpOptions::min_inliers"},
    RemovedFlag{"", "min_relative_rmse_change", "IcpOptions::min_relative_rmse_change"},
    RemovedFlag{"", "min_source_rows", "IcpOptions::min_source_rows"},
    RemovedFlag{"", "min_turn_eigenvalue", "SlamOptions::min_turn_eigenvalue"},
    RemovedFlag{"", "normal_radius", "PreprocessOptions::normal_radius_px"},
    RemovedFlag{"", "openni2_library", "LD_LIBRARY_PATH"},
    RemovedFlag{"", "pyramid_levels", "PreprocessOptions::pyramid_levels"},
    RemovedFlag{"", "readout_s", "readout_s in camera.yaml"},
    RemovedFlag{"", "real_time", "SlamOptions::real_time"},
    RemovedFlag{"", "relocalization", "LoopOptions::relocalization"},
    RemovedFlag{"", "serve_address", "--serve=ADDRESS:PORT"},
    RemovedFlag{"", "serve_surfels", "the default"},
    RemovedFlag{"", "weakly_constrained_photometric_weight",
                "SlamOptions::weakly_constrained_photometric_weight"},
    RemovedFlag{"", "weighting", "FusionOptions::weighting"},
};

}  // namespace

std::string Replacement(const std::string& program, const std::string& flag) {
  for (const RemovedFlag& removed : kRemovedFlags) {
    const std::string of_program = removed.program, replacement = removed.replacement;
    if (flag != removed.flag || (!of_program.empty() && program != of_program)) continue;
    const bool is_field = replacement.find("::") != std::string::npos;
    const std::string remedy =
        is_field ? Concat(" it is an option in C++: ", replacement) : Concat(": use ", replacement);
    return Concat("--", flag, " was removed in 0.2", is_field ? "," : "", remedy);
  }
  return "";
}

}  // namespace surfit::tools
