#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/images/image_files.h"
#include "surfit/core/error.h"

namespace surfit {

// The decoders of each kind of image file, called by what stands in image_files.h. Their bytes are
// a file of that kind whose header claims a size that they can hold (ClaimedSize). All throw
// InputError naming `path`.
RawDepth DecodeDepthPng(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPng(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthTiff(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorTiff(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthPnm(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPnm(const std::string& bytes, const std::string& path);

// A chunk of a PNG: four letters, and its data, which lie in the file's bytes.
struct PngChunk {
  std::string_view type, data;
};

// The chunks of a PNG up to its end. Throws InputError unless they are complete and their checksums
// right (PNG specification, 5.3), so that no decoder gets to guess.
std::vector<PngChunk> PngChunks(const std::string& png, const std::string& path);

// The pixels of a PNG as cameras' recorders write them: not interlaced, of 16 bits of grey or of
// 8 bits of red, green and blue. Nothing if it is not quite so: libpng is to read it, or to refuse
// it.
std::optional<Image<std::uint16_t>> ReadPlainCounts(const std::vector<PngChunk>& png);
std::optional<Image<Rgb8>> ReadPlainColor(const std::vector<PngChunk>& png);

bool IsTiff(const std::string& bytes);
bool IsPnm(const std::string& bytes);  // PGM and PPM

// The size that a PGM or PPM claims.
ImageSize PnmSize(const std::string& bytes, const std::string& path);

InputError NotADepthImage(int channels, int bits, const std::string& path);
InputError DamagedImage(const std::string& path);

}  // namespace surfit
