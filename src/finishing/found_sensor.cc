#include "finishing/found_sensor.h"

#include <cmath>

#include "surfit/core/error.h"
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

std::string DoubtOfGiven(const DepthSensor& given, const DepthCalibration& found) {
  constexpr double kLimit = 23.2;  // of chi square with 10 degrees of freedom, 1 in 100
  const PinholeCamera &a = given.camera, &b = found.camera;
  const CalibrationPrior& prior = given.prior;
  double squared_distance = 0;
  const auto add = [&](double difference, double sigma) {
    squared_distance += difference * difference / (sigma * sigma);
  };
  add(b.fx / a.fx - 1, prior.focal_share);
  add(b.fx / b.fy * (a.fy / a.fx) - 1, prior.aspect_share);
  add(b.cx - a.cx, prior.center_px);
  add(b.cy - a.cy, prior.center_px);
  for (const double c : found.field.coefficients) add(c, prior.inverse_depth_sigma);
  if (squared_distance <= kLimit) return "";
  return Concat(
      "the camera that was found is too far from the given one to be the same sensor "
      "(squared distance ",
      std::round(squared_distance), ", limit ", kLimit,
      "): intrinsics, depth scale or image size may be those of another camera, and then "
      "neither poses nor map are right");
}

}  // namespace surfit
