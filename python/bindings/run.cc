// Whole runs with all their files, as surfit_slam makes them.
#include <atomic>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/run/slam_run.h"

namespace surfit::python {
namespace {

void BindRunProgress(py::module_& module) {
  BindReport<SlamRunProgress>(module, "SlamRunProgress", "How far a run has come.")
      .def_readonly(FIELD(SlamRunProgress, frames_done), "frames")
      .def_readonly(FIELD(SlamRunProgress, frames_total), "frames")
      .def_readonly(FIELD(SlamRunProgress, map_points), "surfels")
      .def_readonly(FIELD(SlamRunProgress, elapsed_s), "since the run began")
      .def_readonly(FIELD(SlamRunProgress, frames_fused_anew), "of the final map");
}

void BindRunSummary(py::module_& module) {
  using Summary = SlamRunSummary;
  BindReport<Summary>(module, "SlamRunSummary", "The outcome of a run: see summary.json for times.")
      .def_readonly(FIELD(Summary, frames_total), "read or attempted")
      .def_readonly(FIELD(Summary, frames_tracked), "all but lost and skipped ones")
      .def_readonly(FIELD(Summary, frames_lost), "not registered")
      .def_readonly(FIELD(Summary, frames_with_motion),
                    "tracked ones, of whose points more than a tenth move by themselves")
      .def_readonly(FIELD(Summary, frames_confirmed),
                    "of those lost, the ones that the next frame has given a pose")
      .def_readonly(FIELD(Summary, frames_lost_in_motion),
                    "lost ones, where such a one is the last that was tracked")
      .def_readonly(FIELD(Summary, frames_apart),
                    "of whose views parts move apart: the camera may be seen against what moves")
      .def_readonly(FIELD(Summary, frames_fused), "into the map")
      .def_readonly(FIELD(Summary, frames_skipped), "that could not be read")
      .def_readonly(FIELD(Summary, frames_dropped), "offered, but not taken in time")
      .def_readonly(FIELD(Summary, frames_hurried),
                    "offered too fast: fewer of them were fused than map_period says")
      .def_readonly(FIELD(Summary, longest_map_period),
                    "at the worst one of so many frames was fused; 0 where none are offered")
      .def_readonly(FIELD(Summary, pauses), "that a camera was unplugged, and came back")
      .def_readonly(FIELD(Summary, paused_s), "in all")
      .def_readonly(FIELD(Summary, frames_without_intensities),
                    "tracked by their shapes alone though intensities were asked for")
      .def_readonly(FIELD(Summary, input_points), "pixels of all frames read")
      .def_readonly(FIELD(Summary, input_points_valid), "of those, with depth")
      .def_readonly(FIELD(Summary, updated), "surfels, summed over all frames")
      .def_readonly(FIELD(Summary, added), "surfels, summed over all frames")
      .def_readonly(FIELD(Summary, removed), "surfels, summed over all frames")
      .def_readonly(FIELD(Summary, map_points), "surfels at the end")
      .def_readonly(FIELD(Summary, compression_ratio), "input_points / map_points")
      .def_readonly(FIELD(Summary, evaluation), "None without ground truth")
      .def_readonly(FIELD(Summary, sensor_latency_s),
                    "that poses are earlier than the files' stamps")
      .def_readonly(FIELD(Summary, ate_without_latency),
                    "the absolute error if poses had the files' stamps; None without ground truth")
      .def_readonly(FIELD(Summary, mount),
                    "MountFit with the option fit_mount and ground truth, else None")
      .def_readonly(FIELD(Summary, total_s), "wall time")
      .def_readonly(FIELD(Summary, final_map_s),
                    "of it to fuse the map anew; None where it was not")
      .def_readonly(FIELD(Summary, peak_rss_bytes), "of the process")
      .def_readonly(FIELD(Summary, digest), "of trajectory and map: see Slam.digest");
}

// A signal or an exception of `progress` ends the run, which writes all its files first.
SlamRunSummary RunInterruptibly(const SlamRunOptions& options, const py::object& progress) {
  std::atomic<bool> interrupted{false};
  std::optional<py::error_already_set> error;
  const auto report = [&](const SlamRunProgress& state) {
    const py::gil_scoped_acquire acquire;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none()) progress(state);
    } catch (const py::error_already_set& raised) {
      if (!error) error = raised;
      interrupted = true;
    }
  };
  SlamRunSummary summary;
  {
    const py::gil_scoped_release release;
    summary = RunSlam(options, interrupted, report);
  }
  if (error) throw py::error_already_set(*error);
  return summary;
}

}  // namespace

void BindRun(py::module_& module) {
  BindRunProgress(module);
  BindRunSummary(module);
  module.def(
      "run_slam",
      [](SlamRunOptions options, const py::object& progress) {
        return RunInterruptibly(options, progress);
      },
      py::arg("options"), py::arg("progress") = py::none(),
      "Runs SLAM over a sequence and writes what surfit_slam writes. progress is called with a "
      "SlamRunProgress after every frame, and after every one of the final map. An exception "
      "there, or Ctrl-C, ends the run after the frame at work; the files are written, and the "
      "exception goes on.");
}

}  // namespace surfit::python
