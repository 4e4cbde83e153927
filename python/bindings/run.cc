// SLAM runs with all their files, like surfit_slam.
#include <atomic>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/run/slam_run.h"

namespace surfit::python {
namespace {

void BindRunProgress(py::module_& module) {
  BindReport<SlamRunProgress>(module, "SlamRunProgress", "Progress of a run.")
      .def_readonly(FIELD(SlamRunProgress, frames_done), "processed frames")
      .def_readonly(FIELD(SlamRunProgress, frames_total), "all frames; -1: unknown")
      .def_readonly(FIELD(SlamRunProgress, map_points), "surfels of the map")
      .def_readonly(FIELD(SlamRunProgress, elapsed_s), "time since the start, s")
      .def_readonly(FIELD(SlamRunProgress, frames_reintegrated), "frames fused into the final map");
}

void BindRunSummary(py::module_& module) {
  BindReport<NoiseReport>(module, "NoiseReport", "Depth noise of a run, 1/m.")
      .def_readonly(FIELD(NoiseReport, start), "of the camera file, the preset or the option")
      .def_readonly(FIELD(NoiseReport, measured), "noise of the first frames; None: unknown")
      .def_readonly(FIELD(NoiseReport, used), "noise of all stages")
      .def_readonly(FIELD(NoiseReport, is_applied), "the measured noise is used")
      .def_readonly(FIELD(NoiseReport, frames), "frames read for the measurement")
      .def_readonly(FIELD(NoiseReport, pairs), "compared pairs of frames")
      .def_readonly(FIELD(NoiseReport, samples), "compared pixels");
  using Summary = SlamRunSummary;
  BindReport<Summary>(module, "SlamRunSummary",
                      "Result of a run. The times of stages are in summary.json.")
      .def_readonly(FIELD(Summary, frames_total), "frames read or attempted")
      .def_readonly(FIELD(Summary, frames_tracked), "all frames except lost and skipped frames")
      .def_readonly(FIELD(Summary, frames_lost), "lost frames")
      .def_readonly(FIELD(Summary, frames_with_motion),
                    "tracked frames with more than 10 % moving points")
      .def_readonly(FIELD(Summary, frames_confirmed),
                    "lost frames whose pose was confirmed by the next frame")
      .def_readonly(FIELD(Summary, frames_lost_in_motion),
                    "lost frames whose last tracked frame has moving objects")
      .def_readonly(FIELD(Summary, frames_degenerate),
                    "frames whose depth does not constrain all directions, as along a wall")
      .def_readonly(FIELD(Summary, frames_with_two_motions),
                    "frames with two motions: the camera may be registered to a moving object")
      .def_readonly(FIELD(Summary, frames_fused), "fused frames")
      .def_readonly(FIELD(Summary, frames_skipped), "unreadable frames")
      .def_readonly(FIELD(Summary, frames_dropped), "frames dropped because the run was too slow")
      .def_readonly(FIELD(Summary, frames_with_longer_map_period),
                    "frames that arrived too fast: fewer were fused than map_period requires")
      .def_readonly(
          FIELD(Summary, longest_map_period),
          "largest number of frames per fused frame; 0 unless frames arrive at sensor rate")
      .def_readonly(FIELD(Summary, pauses), "number of disconnections of the camera")
      .def_readonly(FIELD(Summary, paused_s), "total time of disconnections, s")
      .def_readonly(FIELD(Summary, frames_without_intensities),
                    "frames tracked without intensities although they were requested")
      .def_readonly(FIELD(Summary, input_points), "pixels of all frames")
      .def_readonly(FIELD(Summary, input_points_valid), "pixels with depth")
      .def_readonly(FIELD(Summary, updated), "updated surfels, sum over all frames")
      .def_readonly(FIELD(Summary, added), "added surfels, sum over all frames")
      .def_readonly(FIELD(Summary, removed), "removed surfels, sum over all frames")
      .def_readonly(FIELD(Summary, map_points), "surfels at the end")
      .def_readonly(FIELD(Summary, compression_ratio), "input_points / map_points")
      .def_readonly(FIELD(Summary, noise), "depth noise: start, measured and used, 1/m")
      .def_readonly(FIELD(Summary, evaluation), "errors; None without ground truth")
      .def_readonly(FIELD(Summary, sensor_latency_s),
                    "latency subtracted from the timestamps of the files, s")
      .def_readonly(FIELD(Summary, ate_without_latency),
                    "ATE with the timestamps of the files; None without ground truth")
      .def_readonly(FIELD(Summary, mount),
                    "MountFit with the option fit_mount and ground truth, else None")
      .def_readonly(FIELD(Summary, total_s), "wall time, s")
      .def_readonly(FIELD(Summary, final_map_s),
                    "time for the final map, s; None without final map")
      .def_readonly(FIELD(Summary, peak_rss_bytes), "peak memory of the process")
      .def_readonly(FIELD(Summary, digest), "hash of trajectory and map, see Slam.digest");
}

// After a signal or an exception of `progress`, the run ends and writes all files.
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
      "Runs SLAM on a sequence and writes the files of surfit_slam. Calls "
      "progress(SlamRunProgress) "
      "after every frame, and after every frame of the final map. After an exception of progress, "
      "or Ctrl-C, the run ends with the current frame, writes its files, and raises the "
      "exception.");
}

}  // namespace surfit::python
