#pragma once

#include <pybind11/pybind11.h>

namespace surfit::python {

// Each of these adds one concept to the module, in the order in which they need one another.
void BindErrors();
void BindThreads(pybind11::module_& module);
void BindCamera(pybind11::module_& module);
void BindAllOptions(pybind11::module_& module);
void BindFrame(pybind11::module_& module);
void BindSequence(pybind11::module_& module);
void BindIcpResult(pybind11::module_& module);
void BindAlign(pybind11::module_& module);
void BindClouds(pybind11::module_& module);
void BindEvaluation(pybind11::module_& module);
void BindFrameReport(pybind11::module_& module);
void BindSurfels(pybind11::module_& module);
void BindSlam(pybind11::module_& module);
void BindRun(pybind11::module_& module);
void BindRefinement(pybind11::module_& module);
void BindMapEvaluation(pybind11::module_& module);
void BindMesh(pybind11::module_& module);
void BindPoseGraph(pybind11::module_& module);

}  // namespace surfit::python
