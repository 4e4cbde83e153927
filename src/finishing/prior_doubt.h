#pragma once

#include <string>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// A sentence where a depth camera that was found is farther from the given one than what is known
// of such sensors leaves room for, so that the given one may be that of another sensor, or another
// size of image: one in a hundred right ones is. Empty otherwise. Of undistorted and downsampled
// images with the given field applied.
std::string DoubtOfGiven(const DepthSensor& given, const DepthCalibration& found);

}  // namespace surfit
