// Registration of two frames.
#include "bindings/bind.h"
#include "bindings/frame.h"
#include "bindings/options_class.h"
#include "surfit/core/options.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/far_registration.h"

namespace surfit::python {
namespace {

ColoredView ViewOfFrame(const Frame& frame, const PreprocessOptions& options,
                        bool with_intensities) {
  ColoredView view{PreprocessDepth(frame.images.depth_m, frame.sensor, options),
                   frame.images.color};
  if (with_intensities) AddIntensity(view.color, &view.pyramid);
  return view;
}

FarVerdict Align(const Frame& source, const Frame& target, const InitializeOptions& initialize,
                 const std::optional<IcpOptions>& given_icp, const PreprocessOptions& preprocess) {
  const IcpOptions icp = given_icp.value_or(FarIcpOptions());
  Validate(preprocess);
  Validate(initialize);
  Validate(icp);
  const bool with_intensities = icp.error_model.UsesIntensities();
  return RegisterFar(ViewOfFrame(source, preprocess, with_intensities),
                     ViewOfFrame(target, preprocess, with_intensities), initialize, icp);
}

}  // namespace

void BindAlign(py::module_& module) {
  module.def(
      "align",
      // Options by value: another thread may change them while this one works.
      [](const Frame& source, const Frame& target, InitializeOptions initialize,
         std::optional<IcpOptions> icp, PreprocessOptions preprocess) {
        const py::gil_scoped_release release;
        return Align(source, target, initialize, icp, preprocess);
      },
      py::arg("source"), py::arg("target"), py::arg("initialize") = InitializeOptions(),
      py::arg("icp") = py::none(), py::arg("preprocess") = PreprocessOptions(),
      "Registers two frames, by far_icp_options() unless icp says otherwise, from where "
      "initialize.method says: from the identity, or from afar, and verified then. Other threads "
      "run meanwhile; Ctrl-C is not heard before the call returns.");
}

}  // namespace surfit::python
