// Options of registration.
#include <pybind11/eigen.h>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/cloud_normals.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/initialize.h"
#include "surfit/registration/register_clouds.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

void BindErrorModel(py::module_& module) {
  OptionsClass<DepthNoise>(module, "DepthNoise",
                           "Noise of a depth sensor, constant in inverse depth.")
      .Add("inverse_depth_sigma", &DepthNoise::inverse_depth_sigma,
           "standard deviation of 1 / depth, 1/m")
      .Complete();

  OptionsClass<RobustKernel>(module, "RobustKernel", "How large residuals lose their weight.")
      .AddProperty(
          "type", [](const RobustKernel& kernel) { return ToString(kernel.type); },
          [](RobustKernel& kernel, const std::string& name) {
            kernel.type = RobustKernelTypeFromName(name);
          },
          "none, huber, tukey, geman_mcclure or student_t")
      .Add("width", &RobustKernel::width, "in sigmas")
      .Complete();

  OptionsClass<ErrorModel>(
      module, "ErrorModel",
      "What a residual is worth: sigma^2 = floor_sigma_m^2 + (the depth's sigma)^2.")
      .Add("noise", &ErrorModel::noise, "of the depth")
      .Add("floor_sigma_m", &ErrorModel::floor_sigma_m,
           "what map, normals and calibration leave over")
      .Add("kernel", &ErrorModel::kernel, "of residuals in sigmas")
      .Add("estimate_scale", &ErrorModel::estimate_scale,
           "measure the kernel's width in sigmas of the residuals (MAD), not of the model")
      .Add("photometric_weight", &ErrorModel::photometric_weight,
           "of differences of intensities beside those of surfaces; 0 = off")
      .Add("intensity_sigma", &ErrorModel::intensity_sigma, "of intensities from 0 to 1")
      .Add("intensity_kernel", &ErrorModel::intensity_kernel, "of differences of intensities")
      .Complete();
}

void BindIcpOptions(py::module_& module) {
  OptionsClass<AssociationGates>(module, "AssociationGates",
                                 "What a pair of points must satisfy beyond being valid.")
      .Add("max_distance_m", &AssociationGates::max_distance_m, "0 = off")
      .Add("max_normal_angle_rad", &AssociationGates::max_normal_angle_rad, "0 = off")
      .Complete();

  OptionsClass<HeldOptions>(module, "HeldOptions",
                            "What it takes for a direction of motion to be held by the data.")
      .Add("min_eigenvalue", &HeldOptions::min_eigenvalue, "without unit, 0 to 1")
      .Add("min_information_ratio", &HeldOptions::min_information_ratio,
           "so many times what noise of the normals feigns; 0 = off")
      .Complete();

  OptionsClass<IcpOptions>(module, "IcpOptions", "How two surfaces are registered.")
      .Add("solver", &IcpOptions::solver,
           "closed_form_ldlt, closed_form_lu, closed_form_qr, svd, ceres, ceres_per_point or tiny")
      .Add("linear_solver", &IcpOptions::linear_solver,
           "of ceres_per_point: dense_qr, dense_normal_cholesky or sparse_normal_cholesky")
      .Add("residual", &IcpOptions::residual,
           "point_to_plane, point_to_point, symmetric_point_to_plane or plane_to_plane")
      .Add("association", &IcpOptions::association, "projective or kd_tree")
      .Add("middle_levels", &IcpOptions::middle_levels,
           "False: only the coarsest and the finest level")
      .Add("max_iterations", &IcpOptions::max_iterations, "on each level")
      .Add("gates", &IcpOptions::gates, "of the finest level")
      .Add("gate_growth", &IcpOptions::gate_growth, "of the distance gate, on each coarser level")
      .Add("kernel_growth", &IcpOptions::kernel_growth,
           "of the robust kernel's width, on each coarser level")
      .Add("error_model", &IcpOptions::error_model, "of the finest level")
      .Add("min_source_rows", &IcpOptions::min_source_rows,
           "of the finest level, as few rows of the source as this leaves are used; 0 = all")
      .Add("min_coarse_step_px", &IcpOptions::min_coarse_step_px,
           "a coarser level also ends where points move by less of its px")
      .Add("min_relative_rmse_change", &IcpOptions::min_relative_rmse_change,
           "a level ends where RMSE changes by less")
      .Add("min_increment", &IcpOptions::min_increment,
           "or where rad and metres of the step are below")
      .Add("stop_at_rmse_increase", &IcpOptions::stop_at_rmse_increase,
           "or where RMSE rises by more, and inliers do not")
      .Add("min_inliers", &IcpOptions::min_inliers, "pairs; fewer are a failure")
      .Add("min_inlier_share", &IcpOptions::min_inlier_share,
           "of the valid source points; fewer are a failure")
      .Add("held", &IcpOptions::held, "what it takes for a direction to be held")
      .Add("max_free_space_share", &IcpOptions::max_free_space_share,
           "of points in space that the other view saw through; more is a failure; 1 = off")
      .Complete();
}

void BindFrameOptions(py::module_& module) {
  OptionsClass<PreprocessOptions>(module, "PreprocessOptions",
                                  "How a depth image becomes vertex and normal maps.")
      .Add("noise", &PreprocessOptions::noise, "of the depth")
      .Add("filter_radius_px", &PreprocessOptions::filter_radius_px,
           "half the window of the depth filter; 0 = no filter")
      .Add("filter_cutoff", &PreprocessOptions::filter_cutoff,
           "sigmas; depths that differ by more have no weight in the filter")
      .Add("normal_radius_px", &PreprocessOptions::normal_radius_px,
           "differences up to this offset make a normal")
      .Add("max_slant_rad", &PreprocessOptions::max_slant_rad,
           "a surface steeper than this to the ray counts as a depth edge")
      .Add("pyramid_levels", &PreprocessOptions::pyramid_levels,
           "resolutions, as far as the image allows")
      .Complete();

  OptionsClass<InitializeOptions>(
      module, "InitializeOptions",
      "Where registration starts, and what a fit must show that started from afar.")
      .Add("method", &InitializeOptions::method,
           "identity: unverified; so3: the rotation that makes small images most alike; features: "
           "poses that image features, shapes and brightness find")
      .Add("iteration_growth", &InitializeOptions::iteration_growth,
           "from afar, of ICP's max_iterations")
      .Add("min_overlap_share", &InitializeOptions::min_overlap_share,
           "so many points lie on the other view's surface")
      .Add("min_value_correlation", &InitializeOptions::min_value_correlation,
           "of brightness there")
      .Add("min_detail_correlation", &InitializeOptions::min_detail_correlation,
           "of its edges and texture")
      .Add("min_lead", &InitializeOptions::min_lead, "over any other pose, nats per pixel")
      .Add("free_space_growth", &InitializeOptions::free_space_growth,
           "of ICP's max_free_space_share")
      .Complete();
}

void BindCloudOptions(py::module_& module) {
  OptionsClass<CloudNormalOptions>(module, "CloudNormalOptions",
                                   "How normals come from the points around each point of a cloud.")
      .Add("radius_m", &CloudNormalOptions::radius_m, "to begin with; 0 = by the cloud's spacing")
      .Add("max_growth", &CloudNormalOptions::max_growth, "of the radius")
      .Add("noise", &CloudNormalOptions::noise, "of distances from the viewpoint")
      .Add("min_neighbors", &CloudNormalOptions::min_neighbors, "the point itself included")
      .Add("max_thickness", &CloudNormalOptions::max_thickness, "of a plane, for its width")
      .Add("max_normal_sigma_rad", &CloudNormalOptions::max_normal_sigma_rad,
           "standard deviation of the normal")
      .Add("viewpoint", &CloudNormalOptions::viewpoint, "that normals face, metres")
      .Complete();

  OptionsClass<RegisterCloudsOptions>(module, "RegisterCloudsOptions",
                                      "How two clouds are registered.")
      .Add("icp", &RegisterCloudsOptions::icp, "what is about images is not used")
      .Add("reciprocal", &RegisterCloudsOptions::reciprocal,
           "on the finest level, pairs must be each other's nearest points")
      .Add("levels", &RegisterCloudsOptions::levels, "level l uses every 4^l-th source point")
      .Complete();
}

}  // namespace

void BindRegistrationOptions(py::module_& module) {
  BindErrorModel(module);
  BindIcpOptions(module);
  BindFrameOptions(module);
  BindCloudOptions(module);
  module.def("far_icp_options", &FarIcpOptions,
             "The options of ICP for two frames that may lie farther apart than the next frame "
             "from the map.");
}

}  // namespace surfit::python
