#pragma once

#include <memory>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Reads the images of a frame, without depth of low confidence. Throws InputError naming the file
// that cannot be read.
FrameImages ReadFrameFiles(const FrameFiles& files);

// Opens no files before Recording::Read().
std::unique_ptr<Recording> MakeFolderRecording(std::vector<FrameFiles> frames);

}  // namespace surfit
