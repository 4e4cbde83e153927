#include "bindings/frame.h"

#include <cmath>
#include <optional>
#include <utility>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "io/sequences/raw_frames.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit::python {
namespace {

std::optional<py::array_t<std::uint8_t>> ColorView(const py::object& self) {
  const Image<Rgb8>& color = self.cast<const Frame&>().images.color;
  if (color.empty()) return std::nullopt;
  return ViewOf(&color.data()->r, {color.height(), color.width(), 3}, self);
}

py::array_t<float> DepthView(const py::object& self) {
  const Image<float>& depth_m = self.cast<const Frame&>().images.depth_m;
  return ViewOf(depth_m.data(), {depth_m.height(), depth_m.width()}, self);
}

}  // namespace

RgbdCamera CameraOf(const CameraChoice& camera) {
  if (const auto* name = std::get_if<std::string>(&camera)) return CameraPreset(*name);
  if (const auto* both = std::get_if<RgbdCamera>(&camera)) return *both;
  RgbdCamera registered;
  registered.depth = std::get<PinholeCamera>(camera);
  return registered;
}

FrameMaker::FrameMaker(const RgbdCamera& camera, const PrepareOptions& options)
    : camera_(camera),
      mirrored_(camera.depth.fy < 0),
      preparer_(mirrored_ ? Mirrored(camera) : camera, options) {}

Frame FrameMaker::Make(const py::object& color, const py::array& depth, double stamp_s,
                       int index) const {
  ThrowIf(!std::isfinite(stamp_s), "stamp_s is ", stamp_s, ", must be finite");
  FrameImages images{DepthOf(depth), ColorOf(color), "depth", "color"};
  const py::gil_scoped_release release;
  return {PrepareFrame(camera_, preparer_, std::move(images), index, {stamp_s, stamp_s}), sensor(),
          mirrored_};
}

void BindFrame(py::module_& module) {
  py::class_<Frame>(module, "Frame",
                    "A depth image with its colours, undistorted, in the pixels of one pinhole "
                    "camera. The arrays are views of its memory.")
      .def(py::init([](const py::object& color, const py::array& depth, const CameraChoice& camera,
                       double stamp_s, int index, const PrepareOptions& prepare) {
             return FrameMaker(CameraOf(camera), prepare).Make(color, depth, stamp_s, index);
           }),
           py::arg("color"), py::arg("depth"), py::arg("camera"), py::arg("stamp_s") = 0.,
           py::arg("index") = 0, py::arg("prepare") = PrepareOptions(),
           "From a height x width x 3 array of uint8 (red first) or None, and a height x width "
           "array of integers (counts of 1 / depth_units_per_metre; 0 and 65535 are missing) or "
           "floating-point numbers (metres). stamp_s is when they came: the camera's latency is "
           "taken off it. The camera is a PinholeCamera, an RgbdCamera or a preset's name; where "
           "fy < 0 the frame is mirrored: see Sequence.mirrored.")
      .def_property_readonly("depth_m", &DepthView,
                             "height x width, float32, metres along the optical axis; 0 = missing")
      .def_property_readonly("color", &ColorView,
                             "height x width x 3, uint8, red first; None without colour; (0, 0, 0) "
                             "where the colour camera does not see the depth pixel")
      .def_property_readonly(
          "camera", [](const Frame& frame) { return frame.sensor.camera; }, "of these pixels")
      .def_property_readonly(
          "noise", [](const Frame& frame) { return frame.sensor.noise; }, "of the depth")
      .def_readonly(FIELD(Frame, mirrored), "see Sequence.mirrored")
      .def_property_readonly(
          "stamp_s", [](const Frame& frame) { return frame.images.stamp_s; },
          "the moment that depth shows, seconds: its stamp less the camera's latency")
      .def_property_readonly(
          "color_stamp_s", [](const Frame& frame) { return frame.images.color_stamp_s; },
          "the same of colour, less the same latency")
      .def_property_readonly(
          "index", [](const Frame& frame) { return frame.images.index; },
          "position in the sequence");
}

}  // namespace surfit::python
