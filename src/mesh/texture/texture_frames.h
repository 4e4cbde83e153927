#pragma once

#include <string>

#include "surfit/io/sequence.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// Frames of a run of surfit_slam, with the poses, calibration and colour latency of its poses.json.
// Divides the frames into max_frames parts, and selects the frame with the least image motion of
// each part. Omits held-out frames, unreadable frames and frames without colour. `sequence`: input
// of the run. Throws InputError with the path, here or when frames are read. max_frames 0: all
// frames. Each call of the result reads the sequence from the start.
TextureFrames TextureFramesOf(const std::string& run, const SequenceOptions& sequence,
                              int max_frames);

}  // namespace surfit
