#pragma once

#include <optional>

#include "surfit/frame/frame_pyramid.h"

namespace surfit {

// About `count` of a level's points that have normals, in raster order as an image of the same
// width, without intensities: for data association as its source. Nothing if there are hardly more.
//
// Where most of the view is one wall, few points hold the directions along it, and these must stay
// (normal-space sampling: Rusinkiewicz and Levoy, 3DIM 2001; covariance sampling: Gelfand et al.,
// 3DIM 2003). With a point's row c = [p x n, n] of point-to-plane and C = sum c c', its leverage
// c' C^-1 c is its share of what all points know, 6 in all. Half of the sample is spread evenly;
// a point's chance to be in the other half is proportional to its leverage. Rows are walked through
// with the sum of these chances, and a point is taken where it passes a whole number: no random
// numbers, the same points at any number of threads.
std::optional<FrameLevel> CovarianceSample(const FrameLevel& level, int count);

}  // namespace surfit
