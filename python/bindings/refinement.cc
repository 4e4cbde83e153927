// Refinement of runs, like surfit_refine.
#include "apps/solvers/refine_run.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "bindings/without_gil.h"

namespace surfit::python {
namespace {

void BindCalibration(py::module_& module) {
  BindReport<DepthCalibration>(module, "DepthCalibration", "Calibration of a depth camera.")
      .def_readonly(FIELD(DepthCalibration, camera), "camera of undistorted images")
      .def_property_readonly(
          "inverse_depth_field",
          [](const DepthCalibration& calibration) { return calibration.field.coefficients; },
          "coefficients of the correction of 1/z, 1/m: c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2")
      .def_readonly(FIELD(DepthCalibration, readout_s), "readout time of a rolling shutter, s");
}

void BindRefinementSummary(py::module_& module) {
  using Summary = RefineRunSummary;
  BindReport<Summary>(module, "RefineRunSummary", "Result of a refinement.")
      .def_property_readonly(
          "succeeded", [](const Summary& s) { return s.refinement.Succeeded(); },
          "True if poses and calibration are valid")
      .def_property_readonly(
          "termination", [](const Summary& s) { return ToString(s.refinement.termination); },
          "converged, max_rounds; or the failure: too_few_surfels, failed")
      .def_readonly(FIELD(Summary, given), "calibration before")
      .def_readonly(FIELD(Summary, calibration), "calibration after")
      .def_property_readonly(
          "calibration_covariance",
          [](const Summary& s) { return s.refinement.calibration_covariance; },
          "11 x 11: fx fy cx cy, c0 .. c5, readout; 0 for fixed parameters")
      .def_property_readonly(
          "calibration_kept", [](const Summary& s) { return s.refinement.calibration_kept; },
          "True if the input calibration is kept, because the estimate does not differ "
          "significantly")
      .def_property_readonly(
          "rms_before_m", [](const Summary& s) { return s.refinement.before.rms_m; },
          "point-to-plane RMS, m")
      .def_property_readonly(
          "rms_after_m", [](const Summary& s) { return s.refinement.after.rms_m; },
          "point-to-plane RMS, m")
      .def_readonly(FIELD(Summary, poses), "poses of the trajectory")
      .def_readonly(FIELD(Summary, keyframes), "refined keyframes")
      .def_readonly(FIELD(Summary, frames_without_pose), "frames without a pose")
      .def_readonly(FIELD(Summary, frames_unreadable), "unreadable frames")
      .def_readonly(FIELD(Summary, before), "errors before; None without ground truth")
      .def_readonly(FIELD(Summary, after), "errors after; None without ground truth")
      .def_readonly(FIELD(Summary, map_points), "surfels of the map")
      .def_readonly(FIELD(Summary, total_s), "wall time, s");
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
      "Refines the run with the trajectory, the sequence and the output folder of the options, and "
      "writes the files of surfit_refine. Calls progress(line) with lines of text. An exception "
      "of progress is raised when all files are written.");
}

}  // namespace surfit::python
