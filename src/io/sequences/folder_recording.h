#pragma once

#include <memory>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Throws InputError naming the file that cannot be read.
FrameImages ReadFrameFiles(const FrameFiles& files);

// The listed files as a recording.
std::unique_ptr<Recording> MakeFolderRecording(std::vector<FrameFiles> frames);

}  // namespace surfit
