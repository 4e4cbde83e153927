#pragma once

#include <memory>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Reads the images of a frame. Throws InputError naming the file that cannot be read.
FrameImages ReadFrameFiles(const FrameFiles& files);

std::unique_ptr<Recording> MakeFolderRecording(std::vector<FrameFiles> frames);

}  // namespace surfit
