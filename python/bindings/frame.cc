#include "bindings/frame.h"

#include <cmath>
#include <optional>
#include <utility>

#include "bindings/arrays.h"
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

FrameMaker::FrameMaker(const RgbdCamera& camera, const RectifyOptions& options)
    : camera_(camera),
      mirrored_(camera.depth.fy < 0),
      rectifier_(mirrored_ ? Mirrored(camera) : camera, options) {}

Frame FrameMaker::Make(const py::object& color, const py::array& depth, double stamp_s,
                       int index) const {
  ThrowIf(!std::isfinite(stamp_s), "stamp_s is ", stamp_s, ", must be finite");
  FrameImages images{DepthOf(depth), ColorOf(color), "depth", "color"};
  const py::gil_scoped_release release;
  return {RectifyFrame(camera_, rectifier_, std::move(images), index, {stamp_s, stamp_s}), sensor(),
          mirrored_};
}

void BindFrame(py::module_& module) {
  py::class_<Frame>(
      module, "Frame",
      "Undistorted depth image with colour in the pixels of one pinhole camera. Arrays "
      "are views without copy.")
      .def(py::init([](const py::object& color, const py::array& depth, const CameraChoice& camera,
                       double stamp_s, int index, const RectifyOptions& rectify) {
             return FrameMaker(CameraOf(camera), rectify).Make(color, depth, stamp_s, index);
           }),
           py::arg("color"), py::arg("depth"), py::arg("camera"), py::arg("stamp_s") = 0.,
           py::arg("index") = 0, py::arg("rectify") = RectifyOptions(),
           "The argument color is a height x width x 3 array of uint8, red first, or None. The "
           "argument depth is a height x width array of integers (units of 1 / "
           "depth_units_per_metre; 0 and 65535 are missing) or floats (metres). The latency of the "
           "camera is subtracted from stamp_s. The camera is a PinholeCamera, an RgbdCamera or the "
           "name of a preset. If fy < 0, the frame is mirrored, see Sequence.mirrored.")
      .def_property_readonly(
          "depth_m", &DepthView,
          "height x width, float32, depth along the optical axis in m; 0: missing")
      .def_property_readonly("color", &ColorView,
                             "height x width x 3, uint8, red first; None without colour; (0, 0, 0) "
                             "outside of the colour image")
      .def_property_readonly(
          "camera", [](const Frame& frame) { return frame.sensor.camera; }, "camera of the pixels")
      .def_property_readonly(
          "noise", [](const Frame& frame) { return frame.sensor.noise; }, "depth noise")
      .def_readonly(FIELD(Frame, mirrored), "see Sequence.mirrored")
      .def_property_readonly(
          "stamp_s", [](const Frame& frame) { return frame.images.stamp_s; },
          "capture time of depth, s: timestamp minus latency_s of the camera")
      .def_property_readonly(
          "color_stamp_s", [](const Frame& frame) { return frame.images.color_stamp_s; },
          "capture time of colour, s: timestamp minus latency_s and color_latency_s of the camera")
      .def_property_readonly(
          "index", [](const Frame& frame) { return frame.images.index; },
          "position in the sequence");
}

}  // namespace surfit::python
