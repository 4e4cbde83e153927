// Cameras and the well-known ones.
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "core/field_count.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/camera_files.h"

namespace surfit::python {

static_assert(FieldCount<PinholeCamera>() == 7 && FieldCount<Disparity>() == 4 &&
                  FieldCount<RgbdCamera>() == 12,
              "each field must be an attribute");

void BindCamera(py::module_& module) {
  BindPlain<PinholeCamera>(module, "PinholeCamera",
                           "A pinhole camera: u = fx x/z + cx, v = fy y/z + cy; x right, y down, z "
                           "forward; the centre of the first pixel is (0, 0).")
      .def_readwrite(FIELD(PinholeCamera, width), "px")
      .def_readwrite(FIELD(PinholeCamera, height), "px")
      .def_readwrite(FIELD(PinholeCamera, fx), "px")
      .def_readwrite(FIELD(PinholeCamera, fy), "px; negative in files whose image y axis points up")
      .def_readwrite(FIELD(PinholeCamera, cx), "px")
      .def_readwrite(FIELD(PinholeCamera, cy), "px")
      .def_readwrite(FIELD(PinholeCamera, distortion), "OpenCV's k1 k2 p1 p2 k3");

  BindOptions<DepthNoise>(module, "DepthNoise",
                          "Noise of a depth sensor, constant in inverse depth.");
  BindOptions<CalibrationPrior>(module, "CalibrationPrior",
                                "What is known of a calibration: standard deviations.");
  BindPlain<Disparity>(module, "Disparity",
                       "How disparities become depth: 1/z = (count - count_at_infinity) / "
                       "(counts_per_px * focal_px * baseline_m).")
      .def_readwrite(FIELD(Disparity, focal_px), "that the disparities were made with")
      .def_readwrite(FIELD(Disparity, baseline_m), "metres; 0: depth images are no disparities")
      .def_readwrite(FIELD(Disparity, counts_per_px),
                     "negative where counts fall with the disparity")
      .def_readwrite(FIELD(Disparity, count_at_infinity), "that is no depth's");
  BindPlain<RgbdCamera>(module, "RgbdCamera",
                        "A depth sensor: a depth camera with a colour camera beside it.")
      .def_readwrite(FIELD(RgbdCamera, depth), "the depth camera")
      .def_readwrite(FIELD(RgbdCamera, color), "the colour camera; unused if color_is_registered")
      .def_readwrite(FIELD(RgbdCamera, color_is_registered),
                     "whether colour pixels see the same rays as depth pixels")
      .def_readwrite(FIELD(RgbdCamera, color_from_depth),
                     "4 x 4, metres; unused if color_is_registered")
      .def_readwrite(FIELD(RgbdCamera, depth_units_per_metre),
                     "counts of uint16 depth in a metre; unused where disparity is given")
      .def_readwrite(FIELD(RgbdCamera, disparity), "how depth images of disparities become depth")
      .def_readwrite(FIELD(RgbdCamera, noise), "of the depth")
      .def_readwrite(FIELD(RgbdCamera, frames_per_second), "for files without stamps")
      .def_readwrite(FIELD(RgbdCamera, latency_s),
                     "how long before its stamp the middle of a depth frame's exposure and readout "
                     "lies, seconds")
      .def_readwrite(FIELD(RgbdCamera, color_latency_s),
                     "how much longer the middle of a colour frame's exposure and readout lies "
                     "before its stamp, seconds")
      .def_readwrite(FIELD(RgbdCamera, readout_s),
                     "of a rolling shutter: from the first row that is read, at the top, to the "
                     "last, seconds; 0: none")
      .def_readwrite(FIELD(RgbdCamera, prior), "what is known of the other numbers");

  module.def("camera_preset", &CameraPreset, py::arg("name"),
             "The camera of a well-known data set: see camera_preset_names().");
  module.def("camera_preset_names", &CameraPresetNames, "The names that camera_preset() knows.");
}

}  // namespace surfit::python
