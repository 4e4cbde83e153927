#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/trajectory.h"

namespace surfit::python {

// "(480, 640)".
std::string ShapeOf(const pybind11::array& array);

// From a height x width array of integers (counts) or of a floating-point type (metres). Throws
// InputError naming shape or type for any other.
RawDepth DepthOf(const pybind11::array& depth);

// From a height x width x 3 array of uint8, red first; empty from None. Throws InputError naming
// shape or type for any other.
Image<Rgb8> ColorOf(const pybind11::object& color);

// From an N x 3 array of numbers; empty from None. Throws InputError naming `what` and its shape.
std::vector<Eigen::Vector3f> VectorsOf(const pybind11::object& array, const char* what);

// From an N x 8 array: stamp tx ty tz qx qy qz qw, sorted by time; quaternions of any length but
// zero. Or, from a path, ReadTumTrajectory(). Throws InputError naming `what` and the row.
Trajectory TrajectoryOf(const pybind11::object& rows, const char* what);

// The N x 8 array of a trajectory.
pybind11::array_t<double> RowsOf(const Trajectory& trajectory);

// An array that looks at memory of `owner` and keeps it alive: no copy, and not to be written.
template <typename T>
pybind11::array_t<T> ViewOf(const T* data, std::vector<pybind11::ssize_t> shape,
                            const pybind11::object& owner) {
  pybind11::array_t<T> view(std::move(shape), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

}  // namespace surfit::python
