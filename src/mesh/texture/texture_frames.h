#pragma once

#include <string>

#include "surfit/io/sequence.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Frames of a run of surfit_slam with the final poses of its poses.json, its estimated calibration
// and colour latency. Held-out frames are omitted. The other frames are divided into max_frames
// equal parts, and the frame with the least image motion of each part is used; 0: all frames.
// `sequence` is the input of the run. Frames without colour and unreadable frames are skipped.
// Throws InputError with the file name, here or when frames are read.
TextureFrames TextureFramesOf(const std::string& run, const SequenceOptions& sequence,
                              int max_frames);

}  // namespace surfit
