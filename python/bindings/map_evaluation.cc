// Maps against surfaces, and against what the camera saw.
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
  BindReport<MapError>(module, "MapError", "How near a map is to a surface, and how much it holds.")
      .def_readonly(FIELD(MapError, accuracy_m),
                    "from each map point to the nearest reference point, metres")
      .def_readonly(FIELD(MapError, plane_accuracy_m),
                    "to that point's plane, metres; None where the reference has no normals")
      .def_readonly(FIELD(MapError, completeness),
                    "share of the reference with a map point near by")
      .def_readonly(FIELD(MapError, map_points), "that are finite")
      .def_readonly(FIELD(MapError, reference_points), "that are finite");
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
      "Compares the points of a map with those of a reference surface, N x 3 arrays in metres in "
      "one frame.");
}

void BindViewError(py::module_& module) {
  BindReport<ViewError>(module, "ViewError",
                        "How a map, drawn from a frame's pose, differs from it.")
      .def_readonly(FIELD(ViewError, psnr_covered_db), "over what the map covers")
      .def_readonly(FIELD(ViewError, psnr_covered_by_gain_db),
                    "the same with a gain of its own for each channel of a view")
      .def_readonly(FIELD(ViewError, psnr_registered_db),
                    "over what the map covers from where the frame's colours fit it best")
      .def_readonly(FIELD(ViewError, ssim_registered), "likewise")
      .def_readonly(FIELD(ViewError, ssim_covered), "over what the map covers")
      .def_readonly(FIELD(ViewError, psnr_db), "over all pixels")
      .def_readonly(FIELD(ViewError, ssim), "over all pixels")
      .def_readonly(FIELD(ViewError, coverage), "share of the pixels")
      .def_readonly(FIELD(ViewError, depth_error_median_m), "of drawn depth")
      .def_readonly(FIELD(ViewError, depth_error_mean_m), "of drawn depth");
  BindReport<JudgedView>(module, "JudgedView", "A view of the map.")
      .def_readonly(FIELD(JudgedView, frame), "index")
      .def_readonly(FIELD(JudgedView, error), "how far it is from the frame");
  BindReport<ViewEvaluation>(module, "ViewEvaluation", "How much a map looks like what was seen.")
      .def_readonly(FIELD(ViewEvaluation, held_out), "the frames were left out of the map")
      .def_readonly(FIELD(ViewEvaluation, views), "one for each frame judged by")
      .def_readonly(FIELD(ViewEvaluation, mean), "of the views")
      .def_readonly(FIELD(ViewEvaluation, without_color), "frames left out")
      .def_readonly(FIELD(ViewEvaluation, worst_view), "its picture; empty without one");
  module.def(
      "evaluate_views",
      [](const ViewEvaluationOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          return EvaluateViews(options, [&](int views) { call(views); });
        });
      },
      py::arg("options"), py::arg("progress") = py::none(),
      "Judges the run that the options name by views of its map, and writes what "
      "surfit_evaluate --what=views writes. progress is called with the number of views done.");
}

}  // namespace

void BindMapEvaluation(py::module_& module) {
  BindMapError(module);
  BindViewError(module);
}

}  // namespace surfit::python
