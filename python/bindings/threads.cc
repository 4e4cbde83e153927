// Errors and threads: what all of the module shares.
#include <glog/logging.h>

#include <memory>

#include "bindings/bind.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit::python {
namespace {

// A ThreadLimit for a with statement.
class ScopedThreadLimit {
 public:
  explicit ScopedThreadLimit(int threads) : threads_(threads) {}
  void Enter() { limit_ = std::make_unique<ThreadLimit>(threads_); }
  void Exit() { limit_.reset(); }

 private:
  int threads_;
  std::unique_ptr<ThreadLimit> limit_;
};

}  // namespace

void BindErrors() {
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const InputError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  // Warnings go to stderr, without glog's remark that nobody set it up, and to no files.
  if (!google::IsGoogleLoggingInitialized()) {
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_WARNING;  // what is taken for granted is Sequence.assumed
    google::InitGoogleLogging("surfit");
  }
}

void BindThreads(py::module_& module) {
  py::class_<ScopedThreadLimit>(
      module, "ThreadLimit",
      "Bounds the threads that compute at the same time in this process, reading included:\n"
      "    with surfit.ThreadLimit(2): ...\n"
      "Of nested limits the smallest holds. Results do not depend on it.")
      .def(py::init<int>(), py::arg("threads"))
      .def("__enter__",
           [](ScopedThreadLimit& limit) -> ScopedThreadLimit& {
             limit.Enter();
             return limit;
           })
      .def("__exit__", [](ScopedThreadLimit& limit, const py::args&) { limit.Exit(); });
  module.def("thread_count", &ThreadCount,
             "The number of threads that may compute at the same time now.");
}

}  // namespace surfit::python
