#pragma once

#include "io/recording.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/io/frame_source.h"

namespace surfit {

// Adds to the camera, ground truth and warnings in `info` what only an image tells: the camera's
// sizes where they are unknown, doubts about the depth scale, and with them the frames' camera.
// Mirrors the ground truth where the camera is, and logs the warnings. Returns what prepares the
// frames. Throws InputError naming the image whose size is not the camera's.
FramePreparer CompleteInfo(const FrameImages& first, const PrepareOptions& options,
                           SequenceInfo* info);

}  // namespace surfit
