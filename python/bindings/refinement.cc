// Refinement of whole runs, as surfit_refine does it.
#include "apps/solvers/refine_run.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"

namespace surfit::python {
namespace {

void BindCalibration(py::module_& module) {
  BindReport<DepthCalibration>(module, "DepthCalibration",
                               "What refinement finds of a depth camera.")
      .def_readonly(FIELD(DepthCalibration, camera), "px, undistorted")
      .def_property_readonly(
          "inverse_depth_field",
          [](const DepthCalibration& calibration) { return calibration.field.coefficients; },
          "1/m: what is added to 1/z: c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2")
      .def_readonly(FIELD(DepthCalibration, readout_s), "of a rolling shutter");
}

void BindRefinementSummary(py::module_& module) {
  using Summary = RefineRunSummary;
  BindReport<Summary>(module, "RefineRunSummary", "The outcome of a refinement.")
      .def_property_readonly(
          "succeeded", [](const Summary& s) { return s.refinement.Succeeded(); },
          "whether poses and calibration may be used")
      .def_property_readonly(
          "termination", [](const Summary& s) { return ToString(s.refinement.termination); },
          "converged, max_rounds; or the failure: too_few_surfels, failed")
      .def_readonly(FIELD(Summary, given), "the calibration before")
      .def_readonly(FIELD(Summary, calibration), "and after")
      .def_property_readonly(
          "calibration_covariance",
          [](const Summary& s) { return s.refinement.calibration_covariance; },
          "11 x 11: fx fy cx cy, c0 .. c5, readout; zero of what was held")
      .def_property_readonly(
          "calibration_kept", [](const Summary& s) { return s.refinement.calibration_kept; },
          "the given one is right, as far as noise lets tell")
      .def_property_readonly(
          "rms_before_m", [](const Summary& s) { return s.refinement.before.rms_m; },
          "point to plane")
      .def_property_readonly(
          "rms_after_m", [](const Summary& s) { return s.refinement.after.rms_m; },
          "point to plane")
      .def_readonly(FIELD(Summary, poses), "of the trajectory")
      .def_readonly(FIELD(Summary, keyframes), "of these, refined")
      .def_readonly(FIELD(Summary, frames_without_pose), "frames")
      .def_readonly(FIELD(Summary, frames_unreadable), "frames")
      .def_readonly(FIELD(Summary, before), "evaluation; None without ground truth")
      .def_readonly(FIELD(Summary, after), "evaluation; None without ground truth")
      .def_readonly(FIELD(Summary, map_points), "surfels")
      .def_readonly(FIELD(Summary, total_s), "wall time");
}

}  // namespace

void BindRefinement(py::module_& module) {
  BindCalibration(module);
  BindRefinementSummary(module);
  module.def(
      "refine_run",
      [](const RefineRunOptions& options, const py::object& progress) {
        return WithoutGil(progress, [&](const auto& call) {
          return RunRefinement(options, [&](const std::string& line) { call(line); });
        });
      },
      py::arg("options"), py::arg("progress") = py::none(),
      "Refines the run whose trajectory, sequence and output folder the options name, and writes "
      "what surfit_refine writes. progress is called with lines that tell how far it is; an "
      "exception there goes on when all is written.");
}

}  // namespace surfit::python
