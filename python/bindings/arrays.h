#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bindings/bind.h"
#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::python {

// Text of a shape, e.g. "(480, 640)".
std::string ShapeOf(const py::array& array);

// Depth image from a height x width array of integers (raw depth) or floats (metres). Throws
// InputError with the shape or the type of other arrays.
RawDepth DepthOf(const py::array& depth);

// Colour image from a height x width x 3 array of uint8, red first; empty for None. Throws
// InputError with the shape or the type of other arrays.
Image<Rgb8> ColorOf(const py::object& color);

// Vectors from an N x 3 array; empty for None. Throws InputError with `what` and the shape of other
// arrays.
std::vector<Eigen::Vector3f> VectorsOf(const py::object& array, const char* what);

// Trajectory from an N x 8 array (stamp tx ty tz qx qy qz qw), sorted by time, or from the path of
// a TUM file. Quaternions are normalised, and must not be zero. Throws InputError with `what` and
// the row.
Trajectory TrajectoryOf(const py::object& rows, const char* what);

py::array_t<double> RowsOf(const Trajectory& trajectory);

// Read-only array of memory of `owner`, without copy. The array keeps `owner` alive.
template <typename T>
py::array_t<T> ViewOf(const T* data, std::vector<py::ssize_t> shape, const py::object& owner) {
  py::array_t<T> view(std::move(shape), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

// Read-only array of rows of numbers: N x M, or N if each row is one number.
template <typename Scalar, typename Row>
py::array_t<Scalar> RowsView(const std::vector<Row>& rows, const py::object& owner) {
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size())};
  if (sizeof(Row) > sizeof(Scalar)) shape.push_back(sizeof(Row) / sizeof(Scalar));
  return ViewOf(reinterpret_cast<const Scalar*>(rows.data()), shape, owner);
}

// Binds a vector of such rows.
template <typename Scalar, typename Owner, typename Struct, typename Row>
void BindRows(py::class_<Owner>* owner, const char* name, std::vector<Row> Struct::*rows,
              const char* doc) {
  const auto view = [rows](const py::object& self) {
    return RowsView<Scalar>(self.cast<const Owner&>().*rows, self);
  };
  owner->def_property_readonly(name, view, doc);
}

}  // namespace surfit::python
