#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/registration/far_registration.h"
#include "tracking/moving_regions.h"

namespace surfit {

// Frame for tracking and fusion.
struct PreparedFrame {
  const RgbdFrame& measured;
  const RgbdFrame& images;  // calibrated, depth in the middle of the readout
  ColoredView view;
  CameraMotion motion;  // predicted, for the readout
  double readout_s = 0;

  const FrameLevel& surface() const { return view.pyramid.levels.front(); }
  bool HasIntensities() const { return !surface().intensity.empty(); }
};

// Estimated calibration of a sensor.
struct SensorCorrection {
  const DepthCalibration* calibration = nullptr;  // null: as given
  double color_latency_s = 0;                     // beyond the given latency
};

// Prepares frames. A prepared frame may refer to images of this object, which are valid until the
// next frame.
class FramePreparation {
 public:
  // Keeps a reference to the options.
  explicit FramePreparation(const PreprocessOptions& options) : options_(options) {}

  PreparedFrame Prepare(const RgbdFrame& frame, const CameraMotion& motion,
                        const DepthSensor& sensor, const SensorCorrection& correction,
                        bool with_intensities);

  // Removes moving objects.
  PreparedFrame AtRest(PreparedFrame frame, const CellMask& moving);

 private:
  const RgbdFrame& Corrected(const RgbdFrame& frame, const CameraMotion& motion,
                             const DepthSensor& sensor, const SensorCorrection& correction);

  const PreprocessOptions& options_;
  RgbdFrame corrected_;
  RgbdFrame corrected_rest_, measured_rest_;  // without moving objects
};

}  // namespace surfit
