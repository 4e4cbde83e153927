#pragma once

#include <string>

#include "io/image_size.h"
#include "io/recording.h"

namespace surfit {

// The .klg files of ElasticFusion and its Logger, little endian: int32 number of frames; per frame
// int64 stamp (microseconds), int32 size of depth, int32 size of colour, depth (16-bit counts if
// that many bytes, else the same compressed by zlib), colour (red green blue if that many bytes,
// else JPEG; size 0: none).
// The file does not say how large its images are: they have the first JPEG's size, or without any
// the one given (0 x 0: unknown). Where the file ends before its number of frames, those that are
// whole are read, and a warning says so. Throws InputError naming the file if it cannot be read, or
// nothing tells the size.
OpenedRecording OpenKlg(const std::string& path, ImageSize size);

}  // namespace surfit
