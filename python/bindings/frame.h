#pragma once

#include <string>
#include <variant>

#include "bindings/bind.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"

namespace surfit::python {

// A frame with the sensor that its pixels belong to.
struct Frame {
  RgbdFrame images;
  DepthSensor sensor;
  bool mirrored = false;  // see SequenceInfo::mirrored
};

// A preset's name, an RgbdCamera, or a PinholeCamera that depth and colour share.
using CameraChoice = std::variant<std::string, RgbdCamera, PinholeCamera>;
RgbdCamera CameraOf(const CameraChoice& camera);

// Makes frames from arrays as a sequence does from files: undistorted, colour registered to depth,
// and mirrored where fy < 0.
class FrameMaker {
 public:
  // Throws InputError for a bad camera or bad options.
  FrameMaker(const RgbdCamera& camera, const PrepareOptions& options);

  DepthSensor sensor() const {
    return {preparer_.pinhole(), camera_.noise, camera_.readout_s, camera_.prior};
  }
  bool mirrored() const { return mirrored_; }

  // Arrays as for DepthOf() and ColorOf(). Holds the GIL only while it reads them. Throws
  // InputError for arrays that are not of the camera's size.
  Frame Make(const py::object& color, const py::array& depth, double stamp_s, int index) const;

 private:
  RgbdCamera camera_;
  bool mirrored_;
  FramePreparer preparer_;
};

}  // namespace surfit::python
