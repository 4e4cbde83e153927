#include "finishing/found_sensor.h"

#include "surfit/frame/prepare_frame.h"

namespace surfit {

DepthSensor FoundSensor::Of(DepthSensor given) const {
  if (!calibration) return given;
  given.camera = calibration->camera;
  given.readout_s = calibration->readout_s;
  return given;
}

void FoundSensor::Correct(RgbdFrame* frame) const {
  if (calibration) CorrectDepth(calibration->camera, calibration->field, &frame->depth_m);
  frame->color_stamp_s -= color_latency_s;
}

}  // namespace surfit
