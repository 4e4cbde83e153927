#pragma once

#include <string>
#include <variant>

#include "bindings/bind.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"

namespace surfit::python {

// Frame with the sensor of its pixels.
struct Frame {
  RgbdFrame images;
  DepthSensor sensor;
  bool mirrored = false;  // see SequenceInfo::mirrored
};

// Name of a preset, an RgbdCamera, or a PinholeCamera for both depth and colour.
using CameraChoice = std::variant<std::string, RgbdCamera, PinholeCamera>;
RgbdCamera CameraOf(const CameraChoice& camera);

// Creates frames from arrays like a sequence from files: undistorted, colour registered to depth,
// and mirrored if fy < 0.
class FrameMaker {
 public:
  // Throws InputError for an invalid camera or invalid options.
  FrameMaker(const RgbdCamera& camera, const RectifyOptions& options);

  DepthSensor sensor() const {
    return {rectifier_.pinhole(), camera_.noise, camera_.readout_s, camera_.prior};
  }
  bool mirrored() const { return mirrored_; }

  // Arrays as in DepthOf() and ColorOf(). Releases the GIL after reading the arrays. Throws
  // InputError if the image sizes differ from the camera.
  Frame Make(const py::object& color, const py::array& depth, double stamp_s, int index) const;

 private:
  RgbdCamera camera_;
  bool mirrored_;
  FrameRectifier rectifier_;
};

}  // namespace surfit::python
