#pragma once

#include <string>

#include "surfit/io/sequence.h"
#include "surfit/mesh/texture_mesh.h"

namespace surfit {

// The frames of a run of surfit_slam, as it saw them in the end: by the poses of its poses.json, by
// the camera and at colour's moment that it found. Frames that it held out are left out. Of each of
// max_frames equal parts of the others that is given whose image moved least; 0 = all. `sequence`
// is what the run read. Throws InputError naming the file at fault, now or when frames are read; a
// frame that cannot be read or has no colour is passed over.
TextureFrames TextureFramesOf(const std::string& run, const SequenceOptions& sequence,
                              int max_frames);

}  // namespace surfit
