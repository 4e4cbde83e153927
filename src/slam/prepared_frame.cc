#include "slam/prepared_frame.h"

#include <utility>

#include "frame/rolling_shutter.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {

PreparedFrame FrameMaker::Prepare(const RgbdFrame& frame, const CameraMotion& motion,
                                  const DepthSensor& sensor, const Backend* backend,
                                  bool with_intensities) {
  const RgbdFrame& seen = AsSeen(frame, motion, sensor, backend);
  FramePyramid pyramid = PreprocessDepth(seen.depth_m, sensor, options_);
  if (with_intensities) AddIntensity(seen.color, &pyramid);
  return {seen, {std::move(pyramid), seen.color}, motion};
}

// The frame by the depth that calibration has found, in the middle of its readout, with its colours
// as of the moment that was found. They stay where they are: they are looked up by the motion of
// their rows.
const RgbdFrame& FrameMaker::AsSeen(const RgbdFrame& frame, const CameraMotion& motion,
                                    const DepthSensor& sensor, const Backend* backend) {
  const bool is_recalibrated = backend && backend->is_recalibrated();
  const double color_latency_s = backend ? backend->color_latency_s() : 0;
  const bool moves = sensor.readout_s > 0 && !motion.IsZero();
  if (!is_recalibrated && !moves && color_latency_s == 0) return frame;
  seen_ = {frame.index, frame.stamp_s, frame.color_stamp_s - color_latency_s, frame.depth_m, {}};
  if (is_recalibrated) {
    const DepthCalibration& calibration = *backend->calibration();
    CorrectDepth(calibration.camera, calibration.field, &seen_.depth_m);
  }
  if (moves) seen_ = AtMiddleOfReadout(seen_, sensor, motion);
  seen_.color = frame.color;
  return seen_;
}

// The frame as given without what moves.
const RgbdFrame& FrameMaker::AtRest(const RgbdFrame& frame, const CellMask& moving) {
  if (moving.empty()) return frame;
  rest_ = frame;
  rest_.depth_m = Without(std::move(rest_.depth_m), moving);
  return rest_;
}

PreparedFrame FrameMaker::AtRest(PreparedFrame frame, const CellMask& moving) {
  if (moving.empty()) return frame;
  seen_rest_ = frame.images;
  seen_rest_.depth_m = Without(std::move(seen_rest_.depth_m), moving);
  frame.view.pyramid = Without(std::move(frame.view.pyramid), moving);
  return {seen_rest_, std::move(frame.view), frame.motion};
}

}  // namespace surfit
