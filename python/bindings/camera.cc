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
                           "Pinhole camera: u = fx x/z + cx, v = fy y/z + cy; x right, y down, z "
                           "forward; the centre of the first pixel is (0, 0).")
      .def_readwrite(FIELD(PinholeCamera, width), "image width, px")
      .def_readwrite(FIELD(PinholeCamera, height), "image height, px")
      .def_readwrite(FIELD(PinholeCamera, fx), "focal length, px")
      .def_readwrite(FIELD(PinholeCamera, fy),
                     "focal length, px; negative if the image y axis points up")
      .def_readwrite(FIELD(PinholeCamera, cx), "principal point, px")
      .def_readwrite(FIELD(PinholeCamera, cy), "principal point, px")
      .def_readwrite(FIELD(PinholeCamera, distortion), "distortion of OpenCV: k1 k2 p1 p2 k3");

  BindOptions<DepthNoise>(module, "DepthNoise",
                          "Noise of a depth sensor, constant in inverse depth.");
  BindOptions<CalibrationPrior>(module, "CalibrationPrior",
                                "Prior of a calibration: standard deviations.");
  BindPlain<Disparity>(module, "Disparity",
                       "Conversion of disparities to depth: 1/z = (count - count_at_infinity) / "
                       "(counts_per_px * focal_px * baseline_m).")
      .def_readwrite(FIELD(Disparity, focal_px), "focal length used to compute the disparities, px")
      .def_readwrite(FIELD(Disparity, baseline_m),
                     "baseline, m; 0: depth images are not disparities")
      .def_readwrite(
          FIELD(Disparity, counts_per_px),
          "raw values per pixel of disparity; negative if raw values decrease with the disparity")
      .def_readwrite(FIELD(Disparity, count_at_infinity), "raw value at infinite depth");
  BindPlain<RgbdCamera>(module, "RgbdCamera", "RGB-D sensor: a depth camera and a colour camera.")
      .def_readwrite(FIELD(RgbdCamera, depth), "depth camera")
      .def_readwrite(FIELD(RgbdCamera, color), "colour camera; unused if color_is_registered")
      .def_readwrite(FIELD(RgbdCamera, color_is_registered),
                     "True if colour pixels are registered to depth pixels")
      .def_readwrite(FIELD(RgbdCamera, color_from_depth),
                     "extrinsics, 4 x 4, m; unused if color_is_registered")
      .def_readwrite(FIELD(RgbdCamera, depth_units_per_metre),
                     "raw depth units per metre; unused with disparity")
      .def_readwrite(FIELD(RgbdCamera, disparity), "conversion of disparity images to depth")
      .def_readwrite(FIELD(RgbdCamera, noise), "depth noise")
      .def_readwrite(FIELD(RgbdCamera, frames_per_second), "frame rate of files without timestamps")
      .def_readwrite(
          FIELD(RgbdCamera, latency_s),
          "time from the middle of the exposure and readout of depth to the timestamp, s")
      .def_readwrite(FIELD(RgbdCamera, color_latency_s),
                     "latency of colour in addition to the latency of depth, s")
      .def_readwrite(
          FIELD(RgbdCamera, readout_s),
          "time from the first row of a rolling shutter, at the top, to the last row, s; "
          "0: global shutter")
      .def_readwrite(FIELD(RgbdCamera, prior), "prior of the calibration");

  module.def("camera_preset", &CameraPreset, py::arg("name"),
             "Camera of a public data set, see camera_preset_names().");
  module.def("camera_preset_names", &CameraPresetNames, "Names of the camera presets.");
}

}  // namespace surfit::python
