// Options of the pipeline.
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/slam/slam.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

void BindFusionOptions(py::module_& module) {
  OptionsClass<FusionOptions>(module, "FusionOptions", "How frames become surfels.")
      .Add("weighting", &FusionOptions::weighting,
           "of points: confidence (less off the image's centre) or uniform")
      .Add("max_distance_m", &FusionOptions::max_distance_m,
           "along the surfel's normal, between a point and the surfel it merges with")
      .Add("max_normal_angle_rad", &FusionOptions::max_normal_angle_rad, "between their normals")
      .Add("max_spacing_m", &FusionOptions::max_spacing_m, "between them across the surface")
      .Add("double_share", &FusionOptions::double_share,
           "of two surfels closer than this share of their radii one is removed; 0 = none")
      .Add("max_slant_scale", &FusionOptions::max_slant_scale, "of a radius, on slanted surfaces")
      .Add("max_radius_ratio", &FusionOptions::max_radius_ratio,
           "points that are coarser do not move a surfel")
      .Add("lasting_confidence", &FusionOptions::lasting_confidence,
           "surfels with less are removed when not seen for max_dormant_frames")
      .Add("max_dormant_frames", &FusionOptions::max_dormant_frames, "fused frames")
      .Add("max_confidence", &FusionOptions::max_confidence, "so that the map can still change")
      .Add("active_frames", &FusionOptions::active_frames,
           "surfels not seen in so many fused frames meet no points; 0 = no limit")
      .Add("max_map_points", &FusionOptions::max_map_points,
           "a map of so many surfels takes no further ones; 0 = no limit")
      .Add("free_space_margin_m", &FusionOptions::free_space_margin_m,
           "what is measured farther behind a surfel, plus 4 sigma, removes it")
      .Add("noise", &FusionOptions::noise, "of the depth")
      .Complete();
}

void BindRenderOptions(py::module_& module) {
  OptionsClass<RenderOptions>(module, "RenderOptions", "How the map is drawn for tracking.")
      .Add("stable_confidence", &RenderOptions::stable_confidence,
           "surfels with less are drawn only where no others are")
      .Add("radius_share", &RenderOptions::radius_share,
           "a disc covers pixels within this share of its radius")
      .Add("max_half_window_px", &RenderOptions::max_half_window_px,
           "of the pixels that one disc may cover")
      .Add("surface_thickness_m", &RenderOptions::surface_thickness_m,
           "discs so far behind the first, plus 4 sigma, are the same surface")
      .Add("noise", &RenderOptions::noise, "of the depth")
      .Complete();
}

}  // namespace

void BindSlamOptions(py::module_& module) {
  BindFusionOptions(module);
  BindRenderOptions(module);
  OptionsClass<SlamOptions>(module, "SlamOptions", "How the camera is tracked and the map is made.")
      .Add("preprocess", &SlamOptions::preprocess, "of depth images")
      .Add("icp", &SlamOptions::icp, "of frame and map")
      .Add("fusion", &SlamOptions::fusion, "of frames into the map")
      .Add("render", &SlamOptions::render, "of the map")
      .Add("tracking", &SlamOptions::tracking, "frame_to_model or frame_to_frame")
      .Add("map_period", &SlamOptions::map_period,
           "of so many frames one is fused, and one gets a view of the map of its own; 1 = all")
      .Add("max_view_shift", &SlamOptions::max_view_shift,
           "of the image, as a share of its width: then a frame gets its own view in any case")
      .Add("min_turn_eigenvalue", &SlamOptions::min_turn_eigenvalue,
           "after a frame that holds a direction of motion less, nothing takes turns; 0 = never")
      .Add(
          "motion_model", &SlamOptions::motion_model,
          "where tracking starts: constant_velocity, constant_pose, or so3 (the last pose, turned)")
      .Add("min_inlier_share", &SlamOptions::min_inlier_share,
           "a frame with a smaller share of paired points is lost")
      .Add("max_rmse_m", &SlamOptions::max_rmse_m, "a frame with larger residuals is lost")
      .Add("initialize", &SlamOptions::initialize,
           "how a lost frame is found from the last good one: features, so3, or identity: not at "
           "all")
      .Add("loops", &SlamOptions::loops, "how they are closed, and a lost camera found")
      .Complete();
}

}  // namespace surfit::python
