// Sequences of files with read-ahead.
#include "surfit/io/sequence.h"

#include <filesystem>
#include <mutex>
#include <utility>
#include <vector>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/frame.h"
#include "bindings/options_class.h"
#include "surfit/run/slam_run.h"

namespace surfit::python {
namespace {

// Iterates over the readable frames. Unreadable frames raise a warning and are listed in skipped().
class Sequence {
 public:
  Sequence(const SequenceOptions& options, int queue_capacity)
      : source_(ReadAhead(OpenSequence(options), queue_capacity)) {}

  const SequenceInfo& info() const { return source_->info(); }
  const std::vector<std::pair<int, std::string>>& skipped() const { return skipped_; }

  Frame Next() {
    while (true) {
      std::optional<ReadResult> result = Read();
      if (!result) throw py::stop_iteration();
      if (result->frame) return {std::move(*result->frame), info().sensor(), info().mirrored};
      Skip(*result);
    }
  }

 private:
  std::optional<ReadResult> Read() {
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> lock(mutex_);
    return source_->Next();
  }
  void Skip(const ReadResult& result) {
    skipped_.emplace_back(result.index, result.error);
    const std::string text = "frame " + std::to_string(result.index) + " skipped: " + result.error;
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }

  std::mutex mutex_;
  std::unique_ptr<FrameSource> source_;
  std::vector<std::pair<int, std::string>> skipped_;
};

SequenceOptions OptionsOf(const py::object& path, const py::kwargs& values) {
  SequenceOptions options;
  if (py::isinstance<SequenceOptions>(path)) {
    options = path.cast<SequenceOptions>();
  } else {
    options.path = path.cast<std::filesystem::path>().string();
  }
  SetOptions(values, py::cast(&options, py::return_value_policy::reference));
  return options;
}

}  // namespace

void BindSequence(py::module_& module) {
  const int default_capacity = SlamRunOptions().queue_capacity;
  py::class_<Sequence>(
      module, "Sequence",
      "Frames of a folder or recording, read ahead by another thread:\n"
      "    for frame in surfit.Sequence('living_room', last=99): ...\n"
      "Unreadable frames are skipped with a RuntimeWarning, and listed in skipped.")
      .def(py::init([](const py::object& path, int queue_capacity, const py::kwargs& options) {
             const SequenceOptions all = OptionsOf(path, options);
             const py::gil_scoped_release release;
             return std::make_unique<Sequence>(all, queue_capacity);
           }),
           py::arg("path"), py::kw_only(), py::arg("queue_capacity") = default_capacity,
           "path: path of a folder or recording, or SequenceOptions. Keywords are options of "
           "SequenceOptions. At most queue_capacity frames are read ahead.")
      .def("__iter__", [](Sequence& sequence) -> Sequence& { return sequence; })
      .def("__next__", &Sequence::Next)
      .def("__len__", [](const Sequence& sequence) { return sequence.info().frame_count; })
      .def_property_readonly(
          "format", [](const Sequence& sequence) { return sequence.info().format; },
          "format, as in SequenceOptions.format")
      .def_property_readonly(
          "camera", [](const Sequence& sequence) { return sequence.info().camera; },
          "camera of the files, which may have fy < 0")
      .def_property_readonly(
          "pinhole", [](const Sequence& sequence) { return sequence.info().pinhole; },
          "camera of the frames: undistorted, downsampled, fy > 0")
      .def_property_readonly(
          "mirrored", [](const Sequence& sequence) { return sequence.info().mirrored; },
          "True if the image y axis of the files points up (fy < 0, left-handed). Camera and world "
          "are "
          "then mirrored by S = diag(1, -1, 1), and poses become S pose S.")
      .def_property_readonly(
          "ground_truth",
          [](const Sequence& sequence) { return RowsOf(sequence.info().ground_truth); },
          "N x 8: stamp tx ty tz qx qy qz qw, world from camera, mirrored like the frames; for "
          "evaluation")
      .def_property_readonly(
          "assumed", [](const Sequence& sequence) { return sequence.info().assumed; },
          "assumptions about the sequence, in two lines: format, image sizes and colour "
          "registration; depth camera and depth scale with their origin")
      .def("__repr__",
           [](const Sequence& sequence) {
             return "<surfit.Sequence: " + sequence.info().assumed + ">";
           })
      .def_property_readonly(
          "warnings", [](const Sequence& sequence) { return sequence.info().warnings; },
          "warnings, e.g. on a doubtful camera or depth scale")
      .def_property_readonly("skipped", &Sequence::skipped,
                             "(index, reason) of unreadable frames so far");
}

}  // namespace surfit::python
