#pragma once

#include <optional>

#include "bindings/bind.h"

namespace surfit::python {

// Runs `work` without the GIL. The argument of `work` is a function that calls `progress`, unless
// `progress` is None. The first exception of `progress` is raised when the work is done.
template <typename Work>
auto WithoutGil(const py::object& progress, const Work& work) {
  namespace py = pybind11;
  std::optional<py::error_already_set> error;
  const auto call = [&](const auto&... values) {
    if (progress.is_none()) return;
    const py::gil_scoped_acquire acquire;
    try {
      if (!error) progress(values...);
    } catch (const py::error_already_set& raised) {
      error = raised;
    }
  };
  auto result = [&] {
    const py::gil_scoped_release release;
    return work(call);
  }();
  if (error) throw py::error_already_set(*error);
  return result;
}

}  // namespace surfit::python
