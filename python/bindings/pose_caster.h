#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "surfit/geometry/rigid3.h"

namespace surfit::python {

// Pose of a 4 x 4 matrix. Throws InputError if the matrix is not a rigid motion.
Rigid3d PoseOf(const pybind11::array_t<double>& matrix);

// Writes the 16 values of the 4 x 4 matrix, row by row.
void WriteMatrix(const Rigid3d& pose, double* numbers);
pybind11::array_t<double> MatrixOf(const Rigid3d& pose);

}  // namespace surfit::python

namespace pybind11::detail {

// Poses are 4 x 4 arrays in Python.
template <>
struct type_caster<surfit::Rigid3d> {
  PYBIND11_TYPE_CASTER(surfit::Rigid3d, const_name("numpy.ndarray[numpy.float64]"));

  bool load(handle source, bool) {
    const auto matrix = array_t<double, array::c_style | array::forcecast>::ensure(source);
    if (!matrix) return false;
    value = surfit::python::PoseOf(matrix);
    return true;
  }
  static handle cast(const surfit::Rigid3d& pose, return_value_policy, handle) {
    return surfit::python::MatrixOf(pose).release();
  }
};

}  // namespace pybind11::detail
