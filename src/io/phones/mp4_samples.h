#pragma once

#include <string>

namespace surfit {

// Frames of the first video track of an MP4 file.
struct Mp4Samples {
  int total = 0;
  // Frames before the start of the edit list, which decoders do not show. Phones write the first
  // frame with a negative time.
  int hidden = 0;
};

// Reads the boxes of an MP4 file (ISO/IEC 14496-12). Throws InputError with the path if it has no
// video track, or if a box is damaged.
Mp4Samples ReadMp4Samples(const std::string& path);

}  // namespace surfit
