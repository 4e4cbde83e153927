#include <glog/logging.h>

#include <memory>

#include "bindings/bind.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit::python {
namespace {

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
  // Warnings are written to stderr, not to files. The initialisation avoids a message of glog.
  if (!google::IsGoogleLoggingInitialized()) {
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_WARNING;  // assumptions are in Sequence.assumed
    google::InitGoogleLogging("surfit");
  }
}

void BindThreads(py::module_& module) {
  py::class_<ScopedThreadLimit>(
      module, "ThreadLimit",
      "Limits the threads that compute at the same time in this process, including readers:\n"
      "    with surfit.ThreadLimit(2): ...\n"
      "The smallest of nested limits applies. Results do not depend on the limit.")
      .def(py::init<int>(), py::arg("threads"))
      .def("__enter__",
           [](ScopedThreadLimit& limit) -> ScopedThreadLimit& {
             limit.Enter();
             return limit;
           })
      .def("__exit__", [](ScopedThreadLimit& limit, const py::args&) { limit.Exit(); });
  module.def("thread_count", &ThreadCount,
             "Present limit of threads that compute at the same time.");
}

}  // namespace surfit::python
