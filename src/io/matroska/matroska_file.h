#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/sequences/frame_bytes.h"

namespace surfit {

// Video track of a Matroska file.
struct MatroskaTrack {
  std::uint64_t number = 0;
  std::uint64_t type = 0;  // 1: video
  std::string name;        // may be empty
  std::string codec;       // CodecID, for example V_MS/VFW/FOURCC
  // Four characters of the pixel format: of the Windows header of V_MS/VFW/FOURCC, or of
  // V_UNCOMPRESSED. Empty for other codecs.
  std::string pixel_format;
  ImageSize size;
  bool is_encoded = false;  // compressed or encrypted beyond the codec
};

// Bytes of one frame of a track.
struct MatroskaBlock {
  std::uint64_t track = 0;  // MatroskaTrack::number
  std::int64_t stamp_ns = 0;
  std::uint64_t at = 0, count = 0;  // position in the file
  bool is_laced = false;            // the block has several frames
};

struct MatroskaAttachment {
  std::string name;
  std::uint64_t at = 0, count = 0;
};

// Content of a Matroska file (RFC 9559), without the data of its frames and attachments.
struct MatroskaContent {
  std::vector<MatroskaTrack> tracks;
  std::vector<MatroskaBlock> blocks;  // in the order of the file
  std::vector<MatroskaAttachment> attachments;
  std::map<std::string, std::string> tags;  // first value of each name
  bool is_truncated = false;                // the last element is incomplete
};

// Reads the elements of a Matroska file, with memory in proportion to the number of frames.
// Elements may have an unknown size, as in files of a recorder that was killed. Throws InputError
// with the path if the file is no Matroska file, or if an element is damaged.
MatroskaContent ReadMatroska(const BinaryFile& file);

}  // namespace surfit
