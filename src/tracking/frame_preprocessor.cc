#include "tracking/frame_preprocessor.h"

#include <utility>

#include "frame/rolling_shutter.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

PreprocessedFrame FramePreprocessor::Preprocess(const RgbdFrame& frame, const CameraMotion& motion,
                                                const DepthSensor& sensor,
                                                const SensorCorrection& correction,
                                                bool with_intensities) {
  const RgbdFrame& images = Corrected(frame, motion, sensor, correction);
  FramePyramid pyramid = PreprocessDepth(images.depth_m, sensor, options_);
  if (with_intensities) AddIntensity(images.color, &pyramid);
  return {frame, images, {std::move(pyramid), images.color}, motion, sensor.readout_s};
}

// Corrects depth and the colour timestamp. Colour pixels are not moved: fusion corrects their
// readout at each lookup.
const RgbdFrame& FramePreprocessor::Corrected(const RgbdFrame& frame, const CameraMotion& motion,
                                              const DepthSensor& sensor,
                                              const SensorCorrection& correction) {
  const bool moves = sensor.readout_s > 0 && !motion.IsZero();
  if (!correction.calibration && !moves && correction.color_latency_s == 0) return frame;
  corrected_ = {frame.index,
                frame.stamp_s,
                frame.color_stamp_s - correction.color_latency_s,
                frame.depth_m,
                {}};
  if (correction.calibration) {
    CorrectDepth(correction.calibration->camera, correction.calibration->field,
                 &corrected_.depth_m);
  }
  if (moves) corrected_ = CorrectRollingShutter(corrected_, sensor, motion);
  corrected_.color = frame.color;
  return corrected_;
}

PreprocessedFrame FramePreprocessor::WithoutMovingObjects(PreprocessedFrame frame,
                                                          const CellMask& moving) {
  if (moving.empty()) return frame;
  measured_static_ = Without(frame.measured, moving);
  corrected_static_ = Without(frame.images, moving);
  frame.view.pyramid = Without(std::move(frame.view.pyramid), moving);
  return {measured_static_, corrected_static_, std::move(frame.view), frame.motion,
          frame.readout_s};
}

}  // namespace surfit
