#pragma once

#include <optional>
#include <string>

#include "surfit/frame/frame_source.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// What a run has found of the sensor, beyond what was given.
struct FoundSensor {
  std::optional<DepthCalibration> calibration;  // none: as given
  double color_latency_s = 0;  // by how much colour was found to be earlier than frames have it

  // The sensor that the frames are seen by.
  DepthSensor Of(DepthSensor given) const;
  // A frame as it was given, to depth and the moment of colour as they were found.
  void Correct(RgbdFrame* frame) const;
};

// A sentence where a depth camera that was found is farther from the given one than what is known
// of such sensors leaves room for, so that the given one may be that of another sensor, or another
// size of image: one in a hundred right ones is. Empty otherwise. Of undistorted and downsampled
// images with the given field applied.
std::string DoubtOfGiven(const DepthSensor& given, const DepthCalibration& found);

}  // namespace surfit
