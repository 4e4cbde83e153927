#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/registration/global_registration.h"
#include "tracking/moving_regions.h"

namespace surfit {

// Input frame with its surfaces. Does not own the images: the input frame must outlive it.
struct PreprocessedFrame {
  const RgbdFrame& measured;  // input frame
  const RgbdFrame& images;    // calibrated, depth at the middle of the readout
  ColoredView view;           // surfaces of `images`; intensities only on request and with colour
  CameraMotion motion;        // predicted motion during the readout
  double readout_s = 0;       // readout time of the sensor; 0: global shutter

  const FrameLevel& surface() const { return view.pyramid.levels.front(); }
  bool HasIntensities() const { return !surface().intensity.empty(); }
};

// Estimates of the back end for Preprocess().
struct SensorCorrection {
  const DepthCalibration* calibration = nullptr;  // null: input calibration
  double color_latency_s = 0;  // s, beyond the input latency; subtracted from color_stamp_s
};

// Corrects frames with the estimated calibration and the camera motion, and preprocesses them. A
// returned frame refers to the input frame or to buffers of this object. The buffers are valid
// until the next call of the same function. Not thread-safe.
class FramePreprocessor {
 public:
  // Keeps a reference to the options.
  explicit FramePreprocessor(const PreprocessOptions& options) : options_(options) {}

  // `motion`: predicted motion during the readout; zero: rolling shutter is not corrected.
  // `sensor`: sensor with the estimated camera and readout. Without colour, `with_intensities` has
  // no effect. With it, aborts if the colour image has another size than the camera.
  PreprocessedFrame Preprocess(const RgbdFrame& frame, const CameraMotion& motion,
                               const DepthSensor& sensor, const SensorCorrection& correction,
                               bool with_intensities);

  // Removes the depth of moving objects from the images and the surfaces. Returns the frame
  // unchanged for an empty mask.
  PreprocessedFrame WithoutMovingObjects(PreprocessedFrame frame, const CellMask& moving);

 private:
  const RgbdFrame& Corrected(const RgbdFrame& frame, const CameraMotion& motion,
                             const DepthSensor& sensor, const SensorCorrection& correction);

  const PreprocessOptions& options_;
  RgbdFrame corrected_;
  RgbdFrame corrected_static_, measured_static_;  // without moving objects
};

}  // namespace surfit
