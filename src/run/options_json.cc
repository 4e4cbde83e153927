#include "run/options_json.h"

#include <string>
#include <type_traits>

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

// Calls f(name, field) for each field. A new field does not compile until it is named here as well:
// the structured binding must name all.

template <typename F>
void VisitFields(DepthNoise& noise, const F& f) {
  auto& [inverse_depth_sigma] = noise;
  f("inverse_depth_sigma", inverse_depth_sigma);
}

template <typename F>
void VisitFields(RobustKernel& kernel, const F& f) {
  auto& [type, width] = kernel;
  f("type", type);
  f("width", width);
}

template <typename F>
void VisitFields(ErrorModel& model, const F& f) {
  auto& [noise, floor_sigma_m, kernel, estimate_scale, photometric_weight, intensity_sigma,
         intensity_kernel] = model;
  f("noise", noise);
  f("floor_sigma_m", floor_sigma_m);
  f("kernel", kernel);
  f("estimate_scale", estimate_scale);
  f("photometric_weight", photometric_weight);
  f("intensity_sigma", intensity_sigma);
  f("intensity_kernel", intensity_kernel);
}

template <typename F>
void VisitFields(AssociationGates& gates, const F& f) {
  auto& [max_distance_m, max_normal_angle_rad] = gates;
  f("max_distance_m", max_distance_m);
  f("max_normal_angle_rad", max_normal_angle_rad);
}

template <typename F>
void VisitFields(HeldOptions& options, const F& f) {
  auto& [min_eigenvalue, min_information_ratio] = options;
  f("min_eigenvalue", min_eigenvalue);
  f("min_information_ratio", min_information_ratio);
}

template <typename F>
void VisitFields(IcpOptions& options, const F& f) {
  auto& [solver, linear_solver, residual, association, middle_levels, max_iterations, gates,
         gate_growth, kernel_growth, error_model, min_source_rows, min_coarse_step_px,
         min_relative_rmse_change, min_increment, stop_at_rmse_increase, min_inliers,
         min_inlier_share, held, max_free_space_share] = options;
  f("solver", solver);
  f("linear_solver", linear_solver);
  f("residual", residual);
  f("association", association);
  f("middle_levels", middle_levels);
  f("max_iterations", max_iterations);
  f("gates", gates);
  f("gate_growth", gate_growth);
  f("kernel_growth", kernel_growth);
  f("error_model", error_model);
  f("min_source_rows", min_source_rows);
  f("min_coarse_step_px", min_coarse_step_px);
  f("min_relative_rmse_change", min_relative_rmse_change);
  f("min_increment", min_increment);
  f("stop_at_rmse_increase", stop_at_rmse_increase);
  f("min_inliers", min_inliers);
  f("min_inlier_share", min_inlier_share);
  f("held", held);
  f("max_free_space_share", max_free_space_share);
}

template <typename F>
void VisitFields(PreprocessOptions& options, const F& f) {
  auto& [noise, filter_radius_px, filter_cutoff, normal_radius_px, max_slant_rad, pyramid_levels] =
      options;
  f("noise", noise);
  f("filter_radius_px", filter_radius_px);
  f("filter_cutoff", filter_cutoff);
  f("normal_radius_px", normal_radius_px);
  f("max_slant_rad", max_slant_rad);
  f("pyramid_levels", pyramid_levels);
}

template <typename T>
constexpr bool kIsPlain = std::is_arithmetic_v<T> || std::is_same_v<T, std::string>;

template <typename T>
Json AsJson(T value) {
  if constexpr (kIsPlain<T>) {
    return value;
  } else if constexpr (std::is_same_v<T, RobustKernelType>) {
    return ToString(value);
  } else {
    Json json;
    VisitFields(value, [&](const char* name, const auto& field) { json[name] = AsJson(field); });
    return json;
  }
}

template <typename T>
void Read(const Json& json, T* value) {
  if constexpr (kIsPlain<T>) {
    *value = json.get<T>();
  } else if constexpr (std::is_same_v<T, RobustKernelType>) {
    *value = RobustKernelTypeFromName(json.get<std::string>());
  } else {
    VisitFields(*value, [&](const char* name, auto& field) { Read(json.at(name), &field); });
  }
}

}  // namespace

Json ToJson(const IcpOptions& options) { return AsJson(options); }
Json ToJson(const PreprocessOptions& options) { return AsJson(options); }

IcpOptions IcpOptionsFromJson(const Json& json) {
  IcpOptions options;
  Read(json, &options);
  return options;
}

PreprocessOptions PreprocessOptionsFromJson(const Json& json) {
  PreprocessOptions options;
  Read(json, &options);
  return options;
}

}  // namespace surfit
