#pragma once

// All casters are included, so that every file converts values in the same way.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "bindings/pose_caster.h"

// Name and pointer of a field, for def_readonly().
#define FIELD(Struct, name) #name, &Struct::name

namespace surfit::python {

namespace py = pybind11;

// Each function binds one topic, in the order of their dependencies.
void BindErrors();
void BindThreads(py::module_& module);
void BindCamera(py::module_& module);
void BindAllOptions(py::module_& module);
void BindFrame(py::module_& module);
void BindSequence(py::module_& module);
void BindIcpResult(py::module_& module);
void BindAlign(py::module_& module);
void BindClouds(py::module_& module);
void BindEvaluation(py::module_& module);
void BindFrameReport(py::module_& module);
void BindSurfels(py::module_& module);
void BindSlam(py::module_& module);
void BindRun(py::module_& module);
void BindRefinement(py::module_& module);
void BindMapEvaluation(py::module_& module);
void BindMesh(py::module_& module);
void BindPoseGraph(py::module_& module);

}  // namespace surfit::python
