// Evaluation of maps: distance to a reference surface, and rendered views.
#include "apps/evaluate/view_evaluation.h"
#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/map_error.h"

namespace surfit::python {
namespace {

void BindMapError(py::module_& module) {
  BindReport<MapError>(module, "MapError", "Accuracy and completeness of a map.")
      .def_readonly(FIELD(MapError, accuracy_m),
                    "distances from map points to the nearest reference points, m")
      .def_readonly(FIELD(MapError, plane_accuracy_m),
                    "distances to the planes of these points, m; None without reference normals")
      .def_readonly(FIELD(MapError, completeness),
                    "ratio of reference points with a map point nearby")
      .def_readonly(FIELD(MapError, map_points), "number of finite map points")
      .def_readonly(FIELD(MapError, reference_points), "number of finite reference points")
      .def_readonly(FIELD(MapError, reference_triangles), "number of triangles; 0 for points");
  module.def(
      "evaluate_map",
      [](const py::object& map, const py::object& reference, const py::object& reference_normals,
         const MapErrorOptions& options) {
        const auto points = VectorsOf(map, "map"), truth = VectorsOf(reference, "reference");
        const auto normals = VectorsOf(reference_normals, "reference_normals");
        ThrowIf(!normals.empty() && normals.size() != truth.size(), "reference_normals has ",
                normals.size(), " rows, must have ", truth.size(), " as reference");
        const py::gil_scoped_release release;
        return ComputeMapError(points, truth, normals, options);
      },
      py::arg("map"), py::arg("reference"), py::arg("reference_normals") = py::none(),
      py::arg("options") = MapErrorOptions(),
      "Compares the points of a map with a reference surface: N x 3 arrays in metres, in the same "
      "frame.");
}

void BindViewError(py::module_& module) {
  BindReport<ViewError>(module, "ViewError",
                        "Difference between a frame and the map rendered from its pose.")
      .def_readonly(FIELD(ViewError, psnr_covered_db), "over pixels covered by the map")
      .def_readonly(FIELD(ViewError, psnr_covered_by_gain_db),
                    "over covered pixels, with a gain per view and channel")
      .def_readonly(FIELD(ViewError, psnr_registered_db),
                    "over covered pixels, from the pose registered by colour")
      .def_readonly(FIELD(ViewError, ssim_registered),
                    "over covered pixels, from the pose registered by colour")
      .def_readonly(FIELD(ViewError, ssim_covered), "over covered pixels")
      .def_readonly(FIELD(ViewError, psnr_db), "over all pixels")
      .def_readonly(FIELD(ViewError, ssim), "over all pixels")
      .def_readonly(FIELD(ViewError, coverage), "ratio of covered pixels")
      .def_readonly(FIELD(ViewError, depth_error_median_m), "error of rendered depth, m")
      .def_readonly(FIELD(ViewError, depth_error_mean_m), "error of rendered depth, m");
  BindReport<EvaluatedView>(module, "EvaluatedView", "Evaluated view of the map.")
      .def_readonly(FIELD(EvaluatedView, frame), "frame index")
      .def_readonly(FIELD(EvaluatedView, error), "difference to the frame");
  BindReport<ViewEvaluation>(module, "ViewEvaluation", "Evaluation of a map by rendered views.")
      .def_readonly(FIELD(ViewEvaluation, held_out), "True if the frames are not part of the map")
      .def_readonly(FIELD(ViewEvaluation, views), "one view per evaluated frame")
      .def_readonly(FIELD(ViewEvaluation, mean), "mean errors")
      .def_readonly(FIELD(ViewEvaluation, without_color), "skipped frames")
      .def_readonly(FIELD(ViewEvaluation, worst_view), "picture of the worst view; empty: none");
  module.def(
      "evaluate_views",
      [](const ViewEvaluationOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          return EvaluateViews(options, [&](int views) { call(views); });
        });
      },
      py::arg("options"), py::arg("progress") = py::none(),
      "Evaluates the run of the options by rendered views of its map. Writes views.json, views.csv "
      "and view_pictures/. Calls progress(number of views).");
}

}  // namespace

void BindMapEvaluation(py::module_& module) {
  BindMapError(module);
  BindViewError(module);
}

}  // namespace surfit::python
