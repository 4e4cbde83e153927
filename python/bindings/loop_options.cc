// Options of loops and relocalisation.
#include "surfit/slam/loop_options.h"

#include "bindings/bind.h"
#include "bindings/options_class.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

void BindKeyframeOptions(py::module_& module) {
  OptionsClass<KeyframeOptions>(module, "KeyframeOptions", "When a frame becomes a keyframe.")
      .Add("max_distance_m", &KeyframeOptions::max_distance_m, "the camera has moved so far")
      .Add("max_angle_rad", &KeyframeOptions::max_angle_rad, "or turned by so much")
      .Add("min_overlap_share", &KeyframeOptions::min_overlap_share,
           "or sees less than this share of what the last keyframe sees")
      .Add("max_frames", &KeyframeOptions::max_frames, "or has moved at all for so many frames")
      .Complete();
  OptionsClass<PlaceViewOptions>(module, "PlaceViewOptions", "What is kept of a keyframe.")
      .Add("max_width", &PlaceViewOptions::max_width, "px; images are halved until no wider")
      .Add("max_features", &PlaceViewOptions::max_features, "spread over the image")
      .Complete();
  OptionsClass<PlaceIndexOptions>(module, "PlaceIndexOptions", "How places are looked up.")
      .Add("tables", &PlaceIndexOptions::tables, "of descriptors, each by bits of its own")
      .Add("bits", &PlaceIndexOptions::bits, "by which a table's descriptors are found")
      .Add("max_hamming", &PlaceIndexOptions::max_hamming,
           "descriptors that differ by more do not show the same")
      .Add("min_similarity", &PlaceIndexOptions::min_similarity, "of a candidate")
      .Complete();
}

void BindVerifyLoopOptions(py::module_& module) {
  using Options = VerifyLoopOptions;
  OptionsClass<Options>(module, "VerifyLoopOptions", "What a loop must show to be accepted.")
      .Add("preprocess", &Options::preprocess, "of normals and coarser levels")
      .Add("icp", &Options::icp, "of the dense registration")
      .Add("min_agreeing_features", &Options::min_agreeing_features, "on a pose")
      .Add("min_inlier_share", &Options::min_inlier_share, "of points with a partner's depth")
      .Add("max_rmse_m", &Options::max_rmse_m, "of the residuals")
      .Add("min_overlap_share", &Options::min_overlap_share, "of points on the other's surface")
      .Add("max_free_space_share", &Options::max_free_space_share, "of points in front of it")
      .Add("min_value_correlation", &Options::min_value_correlation, "of the images")
      .Add("min_detail_correlation", &Options::min_detail_correlation, "of their edges and texture")
      .Add("min_lead", &Options::min_lead, "over any other pose, as a share")
      .Add("max_sigma_m", &Options::max_sigma_m, "in the direction held least")
      .Add("max_sigma_rad", &Options::max_sigma_rad, "of the rotation held least")
      .Add("max_disagreement_m", &Options::max_disagreement_m, "forwards and backwards")
      .Add("max_disagreement_rad", &Options::max_disagreement_rad, "forwards and backwards")
      .Complete();
}

void BindSearchOptions(py::module_& module) {
  OptionsClass<FindLoopsOptions>(module, "FindLoopsOptions", "Which keyframes may be joined.")
      .Add("min_gap", &FindLoopsOptions::min_gap, "frames between the two")
      .Add("max_alike", &FindLoopsOptions::max_alike, "keyframes that look most alike")
      .Add("max_near", &FindLoopsOptions::max_near, "further ones whose poses are nearest")
      .Add("max_near_m", &FindLoopsOptions::max_near_m, "near is no farther")
      .Add("max_near_rad", &FindLoopsOptions::max_near_rad, "nor turned by more")
      .Add("verify", &FindLoopsOptions::verify, "what they must show")
      .Complete();
  OptionsClass<RelocalizeOptions>(module, "RelocalizeOptions", "How a lost camera is found.")
      .Add("max_candidates", &RelocalizeOptions::max_candidates, "keyframes that are tried")
      .Add("verify", &RelocalizeOptions::verify, "what the one must show")
      .Complete();
}

void BindGraphOptions(py::module_& module) {
  OptionsClass<EdgeNoise>(module, "EdgeNoiseOptions", "Errors that registrations do not know of.")
      .Add("shared_points", &EdgeNoise::shared_points, "of odometry, that have one error")
      .Add("odometry_m", &EdgeNoise::odometry_m, "between consecutive keyframes")
      .Add("odometry_rad", &EdgeNoise::odometry_rad, "between consecutive keyframes")
      .Add("odometry_share", &EdgeNoise::odometry_share, "of the way and turn between them")
      .Add("loop_m", &EdgeNoise::loop_m, "of a loop")
      .Add("loop_rad", &EdgeNoise::loop_rad, "of a loop")
      .Complete();
  using Options = PoseGraphOptions;
  OptionsClass<Options>(module, "PoseGraphOptions", "How a pose graph is optimised.")
      .Add("sparse_backend", &Options::sparse_backend, "suite_sparse or eigen_sparse")
      .Add("initialization", &Options::initialization, "given, odometry or chordal")
      .Add("loop_robustness", &Options::loop_robustness, "none, or gnc: wrong loops are left out")
      .Add("max_loop_squared_error", &Options::max_loop_squared_error, "of a right loop")
      .Add("max_iterations", &Options::max_iterations, "in each round of gnc")
      .Add("min_relative_cost_change", &Options::min_relative_cost_change, "ends it")
      .Complete();
}

}  // namespace

void BindLoopOptions(py::module_& module) {
  BindKeyframeOptions(module);
  BindVerifyLoopOptions(module);
  BindSearchOptions(module);
  BindGraphOptions(module);
  OptionsClass<LoopOptions>(module, "LoopOptions", "How loops are closed.")
      .Add("enabled", &LoopOptions::enabled, "whether they are")
      .Add("keyframes", &LoopOptions::keyframes, "when a frame becomes one")
      .Add("views", &LoopOptions::views, "what is kept of them")
      .Add("places", &LoopOptions::places, "how they are looked up")
      .Add("find", &LoopOptions::find, "which are joined")
      .Add("relocalize", &LoopOptions::relocalize, "how a lost camera is found")
      .Add("noise", &LoopOptions::noise, "of edges of the pose graph")
      .Add("graph", &LoopOptions::graph, "how it is optimised")
      .Add("delay_frames", &LoopOptions::delay_frames, "from a keyframe to its effect")
      .Add("active_frames", &LoopOptions::active_frames,
           "FusionOptions.active_frames where that sets no limit")
      .Add("frames_apart", &LoopOptions::frames_apart,
           "surfels so far apart in time are merged where a loop puts them together")
      .Add("min_correction_m", &LoopOptions::min_correction_m, "smaller ones are not applied")
      .Add("max_view_bytes", &LoopOptions::max_view_bytes, "of keyframes")
      .Add("new_map_after", &LoopOptions::new_map_after, "so many lost frames; 0 = never")
      .Complete();
}

}  // namespace surfit::python
