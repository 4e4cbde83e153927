// Cameras and the well-known ones.
#include <pybind11/eigen.h>

#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/io/camera_presets.h"

namespace py = pybind11;

namespace surfit::python {

void BindCamera(py::module_& module) {
  OptionsClass<PinholeCamera>(
      module, "PinholeCamera",
      "A pinhole camera: u = fx x/z + cx, v = fy y/z + cy; x right, y down, z forward; the centre "
      "of the first pixel is (0, 0).")
      .Add("width", &PinholeCamera::width, "px")
      .Add("height", &PinholeCamera::height, "px")
      .Add("fx", &PinholeCamera::fx, "px")
      .Add("fy", &PinholeCamera::fy, "px; negative in files whose image y axis points up")
      .Add("cx", &PinholeCamera::cx, "px")
      .Add("cy", &PinholeCamera::cy, "px")
      .Add("distortion", &PinholeCamera::distortion, "OpenCV's k1 k2 p1 p2 k3")
      .Complete();

  OptionsClass<RgbdCamera>(module, "RgbdCamera", "A depth camera with a colour camera beside it.")
      .Add("depth", &RgbdCamera::depth, "the depth camera")
      .Add("color", &RgbdCamera::color, "the colour camera; unused if color_is_registered")
      .Add("color_is_registered", &RgbdCamera::color_is_registered,
           "whether colour pixels see the same rays as depth pixels")
      .Add("color_from_depth", &RgbdCamera::color_from_depth,
           "4 x 4, metres; unused if color_is_registered")
      .Add("depth_units_per_metre", &RgbdCamera::depth_units_per_metre,
           "counts of uint16 depth in a metre")
      .Add("frames_per_second", &RgbdCamera::frames_per_second, "for files without stamps")
      .Complete();

  module.def("camera_preset", &CameraPreset, py::arg("name"),
             "The camera of a well-known data set: see camera_preset_names().");
  module.def("camera_preset_names", &CameraPresetNames, "The names that camera_preset() knows.");
}

}  // namespace surfit::python
