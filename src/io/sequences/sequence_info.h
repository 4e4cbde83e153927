#pragma once

#include <vector>

#include "io/sequences/recording.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {

// Adds to `info` what only the images show: unknown image sizes, and warnings about the depth scale
// and the registration of colour. Mirrors the ground truth if the camera is mirrored. Logs the
// assumptions and warnings. Returns the rectifier of the frames. Throws InputError naming the image
// if the size of the first images differs from the camera's.
FramePreparer CompleteInfo(const std::vector<FrameImages>& first, const PrepareOptions& options,
                           SequenceInfo* info);

}  // namespace surfit
