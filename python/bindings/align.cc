#include "bindings/bind.h"
#include "bindings/frame.h"
#include "bindings/options_class.h"
#include "surfit/core/options.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/global_registration.h"

namespace surfit::python {
namespace {

ColoredView ViewOfFrame(const Frame& frame, const PreprocessOptions& options,
                        bool with_intensities) {
  ColoredView view{PreprocessDepth(frame.images.depth_m, frame.sensor, options),
                   frame.images.color};
  if (with_intensities) AddIntensity(view.color, &view.pyramid);
  return view;
}

GlobalRegistrationResult Align(const Frame& source, const Frame& target,
                               const InitializeOptions& initialize,
                               const std::optional<IcpOptions>& given_icp,
                               const PreprocessOptions& preprocess) {
  const IcpOptions icp = given_icp.value_or(GlobalIcpOptions());
  Validate(preprocess);
  Validate(initialize);
  Validate(icp);
  const bool with_intensities = icp.error_model.UsesIntensities();
  const ColoredView source_view = ViewOfFrame(source, preprocess, with_intensities);
  const ColoredView target_view = ViewOfFrame(target, preprocess, with_intensities);
  GlobalRegistrationResult result = RegisterGlobally(source_view, target_view, initialize, icp);
  result.icp.covariance =
      CovarianceOfViews(source_view.pyramid, target_view.pyramid, result.icp, icp);
  return result;
}

}  // namespace

void BindAlign(py::module_& module) {
  module.def(
      "align",
      // Options are copied, because another thread may change them during the call.
      [](const Frame& source, const Frame& target, InitializeOptions initialize,
         std::optional<IcpOptions> icp, PreprocessOptions preprocess) {
        const py::gil_scoped_release release;
        return Align(source, target, initialize, icp, preprocess);
      },
      py::arg("source"), py::arg("target"), py::arg("initialize") = InitializeOptions(),
      py::arg("icp") = py::none(), py::arg("preprocess") = PreprocessOptions(),
      "Registers two frames. icp: far_icp_options() if None. initialize.method selects the initial "
      "pose; results of other methods than identity are verified. Other threads run during the "
      "call. Ctrl-C takes effect after the call.");
}

}  // namespace surfit::python
