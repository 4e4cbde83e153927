#pragma once

#include <string>

#include "io/recording.h"

namespace surfit {

// ScanNet's .sens files, see sens_header.h. Per frame: 4 x 4 floats camera-to-world (not finite: no
// pose), uint64 stamps of colour and of depth (microseconds), uint64 sizes of colour and of depth
// in bytes, colour, depth. Frames without stamps, where all of them are 0 or not ascending, get
// index / frames_per_second. What follows the frames (inertial data) is left alone.
// Where the file ends before its number of frames, those that are whole are read, and a warning
// says so. Throws InputError naming the file and what is wrong with it.
OpenedRecording OpenSens(const std::string& path, double frames_per_second);

}  // namespace surfit
