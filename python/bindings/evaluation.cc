#include <algorithm>
#include <filesystem>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::python {
namespace {

void BindErrors(py::module_& module) {
  BindReport<ErrorStatistics>(module, "ErrorStatistics", "Statistics of a set of errors.")
      .def_readonly(FIELD(ErrorStatistics, count), "number of errors")
      .def_readonly(FIELD(ErrorStatistics, rmse), "root mean square")
      .def_readonly(FIELD(ErrorStatistics, mean), "mean")
      .def_readonly(FIELD(ErrorStatistics, median), "median")
      .def_readonly(FIELD(ErrorStatistics, p90), "90 % quantile")
      .def_readonly(FIELD(ErrorStatistics, max), "largest");

  BindReport<AbsoluteTrajectoryError>(
      module, "AbsoluteTrajectoryError",
      "Absolute trajectory error (ATE) of camera positions after rigid alignment.")
      .def_readonly(FIELD(AbsoluteTrajectoryError, translation_m), "position error, m")
      .def_property_readonly(
          "ground_truth_from_estimate",
          [](const AbsoluteTrajectoryError& error) { return error.alignment.target_from_source; },
          "alignment, 4 x 4, m")
      .def_property_readonly(
          "rotation_is_unique",
          [](const AbsoluteTrajectoryError& error) {
            return error.alignment.status == AlignmentStatus::kAligned;
          },
          "False for a straight path: the rotation of the alignment is not unique");

  BindReport<MountFit>(module, "MountFit",
                       "Fit of a constant offset between the bodies of the estimate and of the "
                       "ground truth.")
      .def_readonly(FIELD(MountFit, true_body_in_estimated_m),
                    "origin of the true body in the frame of the estimated body, m")
      .def_readonly(FIELD(MountFit, scale), "true metres per estimated metre; 1 if not fitted")
      .def_readonly(FIELD(MountFit, is_unique), "False if the path does not determine the fit")
      .def_readonly(FIELD(MountFit, ate), "AbsoluteTrajectoryError of the true body");

  BindReport<RelativePoseError>(module, "RelativePoseError",
                                "Relative pose error (RPE) over a fixed interval.")
      .def_readonly(FIELD(RelativePoseError, translation_m), "translation error, m")
      .def_readonly(FIELD(RelativePoseError, rotation_deg), "rotation error, degrees");
}

std::vector<double> StampsOf(const std::optional<std::vector<double>>& stamps_s,
                             const Trajectory& ground_truth) {
  if (!stamps_s) return Stamps(ground_truth);
  std::vector<double> sorted = *stamps_s;
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

void BindEvaluation(py::module_& module) {
  BindErrors(module);
  BindReport<TrajectoryEvaluation>(module, "TrajectoryEvaluation",
                                   "Errors of an estimated trajectory.")
      .def_readonly(FIELD(TrajectoryEvaluation, expected),
                    "number of expected frames with ground truth")
      .def_readonly(FIELD(TrajectoryEvaluation, matched),
                    "number of estimated poses with ground truth")
      .def_readonly(FIELD(TrajectoryEvaluation, coverage), "matched / expected")
      .def_readonly(FIELD(TrajectoryEvaluation, ate), "None if fewer than 3 poses match")
      .def_readonly(FIELD(TrajectoryEvaluation, rpe),
                    "None if no two poses have a distance of delta");

  module.def(
      "evaluate",
      [](const py::object& ground_truth, const py::object& estimate,
         const std::optional<std::vector<double>>& frame_stamps_s,
         TrajectoryEvaluationOptions options) {
        const Trajectory truth = TrajectoryOf(ground_truth, "ground_truth");
        const Trajectory estimated = TrajectoryOf(estimate, "estimate");
        const py::gil_scoped_release release;
        return EvaluateTrajectory(truth, estimated, StampsOf(frame_stamps_s, truth), options);
      },
      py::arg("ground_truth"), py::arg("estimate"), py::arg("frame_stamps_s") = py::none(),
      py::arg("options") = TrajectoryEvaluationOptions(),
      "Computes ATE and RPE of a trajectory. Both trajectories are N x 8 arrays (stamp tx ty tz qx "
      "qy qz qw) or paths of TUM files. The array frame_stamps_s has the timestamps of all "
      "expected frames; None: timestamps of the ground truth.");
  module.def(
      "read_trajectory",
      [](const std::filesystem::path& path) { return RowsOf(ReadTumTrajectory(path.string())); },
      py::arg("path"), "Reads a TUM file as an N x 8 array: stamp tx ty tz qx qy qz qw.");
}

}  // namespace surfit::python
