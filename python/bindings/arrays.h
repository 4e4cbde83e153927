#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bindings/bind.h"
#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::python {

// "(480, 640)".
std::string ShapeOf(const py::array& array);

// From a height x width array of integers (counts) or of a floating-point type (metres). Throws
// InputError naming shape or type for any other.
RawDepth DepthOf(const py::array& depth);

// From a height x width x 3 array of uint8, red first; empty from None. Throws InputError naming
// shape or type for any other.
Image<Rgb8> ColorOf(const py::object& color);

// From an N x 3 array of numbers; empty from None. Throws InputError naming `what` and its shape.
std::vector<Eigen::Vector3f> VectorsOf(const py::object& array, const char* what);

// From an N x 8 array: stamp tx ty tz qx qy qz qw, sorted by time; quaternions of any length but
// zero. Or, from a path, ReadTumTrajectory(). Throws InputError naming `what` and the row.
Trajectory TrajectoryOf(const py::object& rows, const char* what);

// The N x 8 array of a trajectory.
py::array_t<double> RowsOf(const Trajectory& trajectory);

// An array that looks at memory of `owner` and keeps it alive: no copy, and not to be written.
template <typename T>
py::array_t<T> ViewOf(const T* data, std::vector<py::ssize_t> shape, const py::object& owner) {
  py::array_t<T> view(std::move(shape), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

// Makes such a view of rows of numbers: N x M, or N if each row is one number.
template <typename Scalar, typename Row>
py::array_t<Scalar> RowsView(const std::vector<Row>& rows, const py::object& owner) {
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size())};
  if (sizeof(Row) > sizeof(Scalar)) shape.push_back(sizeof(Row) / sizeof(Scalar));
  return ViewOf(reinterpret_cast<const Scalar*>(rows.data()), shape, owner);
}

// Binds a field that holds such rows.
template <typename Scalar, typename Owner, typename Struct, typename Row>
void BindRows(py::class_<Owner>* owner, const char* name, std::vector<Row> Struct::*rows,
              const char* doc) {
  const auto view = [rows](const py::object& self) {
    return RowsView<Scalar>(self.cast<const Owner&>().*rows, self);
  };
  owner->def_property_readonly(name, view, doc);
}

}  // namespace surfit::python
