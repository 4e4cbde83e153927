// Extension module surfit._surfit. surfit/__init__.py exports it as the package.
#include "bindings/bind.h"
#include "core/shared_options.h"

PYBIND11_MODULE(_surfit, module) {
  using namespace surfit::python;
  // Classes and functions have the name of the package, not of this module.
  const py::object name = module.attr("__name__");
  module.attr("__name__") = "surfit";
  BindErrors();
  BindThreads(module);
  BindCamera(module);
  BindAllOptions(module);
  BindFrame(module);
  BindSequence(module);
  BindIcpResult(module);
  BindAlign(module);
  BindClouds(module);
  BindEvaluation(module);
  BindFrameReport(module);
  BindSurfels(module);
  BindSlam(module);
  BindRun(module);
  BindRefinement(module);
  BindMapEvaluation(module);
  BindMesh(module);
  BindPoseGraph(module);
  module.def("_present_name", &surfit::PresentName);
  module.attr("__version__") = SURFIT_VERSION;
  module.attr("__name__") = name;
}
