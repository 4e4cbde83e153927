// Whole runs with all their files, as surfit_slam makes them.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <atomic>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/run/slam_run.h"

namespace py = pybind11;

namespace surfit::python {
namespace {

void BindRunOptions(py::module_& module) {
  OptionsClass<SlamRunOptions>(module, "SlamRunOptions",
                               "What a run is to do, beyond how the SLAM works.")
      .Add("sequence", &SlamRunOptions::sequence, "what to read")
      .Add("slam", &SlamRunOptions::slam, "how the SLAM works")
      .Add("output", &SlamRunOptions::output, "folder for all results; made if missing")
      .Add("initial_pose", &SlamRunOptions::initial_pose,
           "identity, groundtruth or tx,ty,tz,qx,qy,qz,qw")
      .Add("poses", &SlamRunOptions::poses, "track, or groundtruth: fuse along the given poses")
      .Add("threads", &SlamRunOptions::threads, "that compute at the same time")
      .Add("queue_capacity", &SlamRunOptions::queue_capacity,
           "frames that are read ahead, or offered and kept")
      .Add("offered_fps", &SlamRunOptions::offered_fps,
           "rate at which frames are offered, as by a camera; 0 = as fast as they are processed")
      .Add("pictures", &SlamRunOptions::pictures, "whether to draw them")
      .Add("keep_views", &SlamRunOptions::keep_views,
           "whether to keep pictures of a few frames beside the model's views, for surfit_report")
      .Add("trace", &SlamRunOptions::trace, "file for the times of all stages; empty = none")
      .Add("dump_failures", &SlamRunOptions::dump_failures,
           "folder that keeps what tracking lost a frame with; empty = none")
      .Add("record", &SlamRunOptions::record, "options by name, to be kept with the results")
      .Complete();
}

void BindRunProgress(py::module_& module) {
  py::class_<SlamRunProgress>(module, "SlamRunProgress", "How far a run has come.")
      .def_readonly("frames_done", &SlamRunProgress::frames_done, "frames")
      .def_readonly("frames_total", &SlamRunProgress::frames_total, "frames")
      .def_readonly("map_points", &SlamRunProgress::map_points, "surfels")
      .def_readonly("elapsed_s", &SlamRunProgress::elapsed_s, "since the run began");
}

void BindRunSummary(py::module_& module) {
  using Summary = SlamRunSummary;
  py::class_<Summary>(module, "SlamRunSummary", "The outcome of a run: see summary.json for times.")
      .def_readonly("frames_total", &Summary::frames_total, "read or attempted")
      .def_readonly("frames_tracked", &Summary::frames_tracked, "all but lost and skipped ones")
      .def_readonly("frames_lost", &Summary::frames_lost, "not registered")
      .def_readonly("frames_fused", &Summary::frames_fused, "into the map")
      .def_readonly("frames_skipped", &Summary::frames_skipped, "that could not be read")
      .def_readonly("frames_dropped", &Summary::frames_dropped, "offered, but not taken in time")
      .def_readonly("frames_without_intensities", &Summary::frames_without_intensities,
                    "tracked by their shapes alone though intensities were asked for")
      .def_readonly("input_points", &Summary::input_points, "pixels of all frames read")
      .def_readonly("input_points_valid", &Summary::input_points_valid, "of those, with depth")
      .def_readonly("updated", &Summary::updated, "surfels, summed over all frames")
      .def_readonly("added", &Summary::added, "surfels, summed over all frames")
      .def_readonly("removed", &Summary::removed, "surfels, summed over all frames")
      .def_readonly("map_points", &Summary::map_points, "surfels at the end")
      .def_readonly("compression_ratio", &Summary::compression_ratio, "input_points / map_points")
      .def_readonly("evaluation", &Summary::evaluation, "None without ground truth")
      .def_readonly("total_s", &Summary::total_s, "wall time")
      .def_readonly("peak_rss_bytes", &Summary::peak_rss_bytes, "of the process")
      .def_readonly("digest", &Summary::digest, "of trajectory and map: see Slam.digest");
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
  BindRunOptions(module);
  BindRunProgress(module);
  BindRunSummary(module);
  module.def(
      "run_slam",
      [](SlamRunOptions options, const py::object& progress) {
        return RunInterruptibly(options, progress);
      },
      py::arg("options"), py::arg("progress") = py::none(),
      "Runs SLAM over a sequence and writes what surfit_slam writes. progress is called with a "
      "SlamRunProgress after every frame. An exception there, or Ctrl-C, ends the run after the "
      "frame at work; the files are written, and the exception goes on.");
}

}  // namespace surfit::python
