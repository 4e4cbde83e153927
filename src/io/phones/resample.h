#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Largest distance in px between the pixels of one ray in both cameras. The cameras must have equal
// sizes and equal distortion, so that the pixels have an affine relation.
double LargestShift(const PinholeCamera& a, const PinholeCamera& b);

// Resample an image of the camera `own` to the camera `common`, in the same conditions as
// LargestShift(). Phones change the focal length between frames, and tracking has one camera.

// Inverse depth is bilinear, which is exact on planes. Beside missing depth and at depth edges, the
// nearest pixel is used. Pixels outside of the image are 0 (missing).
void ResampleDepth(const PinholeCamera& own, const PinholeCamera& common, RawDepth* depth);

// Bilinear. Pixels outside of the image repeat its border.
void ResampleColor(const PinholeCamera& own, const PinholeCamera& common, Image<Rgb8>* color);

}  // namespace surfit
