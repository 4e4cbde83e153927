#pragma once

#include <vector>

#include "refinement/shared_surfels.h"

namespace surfit {

// From a surfel's centre to the points beside it, in the keyframe that it was made from.
inline constexpr double kTextureRadiusPx = 4;

// Moves each surfel to where its plane agrees best with what keyframes measure, as images are
// expanded there, and adds what those that have measured the plane see of its texture. A keyframe
// sees it where it measures the plane all around the points: what is before or behind that moves
// otherwise in the image. A surfel has none if fewer than two see it, or if for none of them it
// changes by a standard deviation per px. The same at any number of threads.
void ObserveTextures(const std::vector<RefinementKeyframe>& keyframes,
                     const DepthCalibration& calibration, const ErrorModel& model,
                     SharedSurfels* shared);

}  // namespace surfit
