#pragma once

#include <cstdint>
#include <string>

namespace surfit {

// Compression of the chunks of a bag. kNone: not compressed.
enum class Compression { kNone, kLz4, kZstd, kBz2 };

// Parses the compression of a bag; "" and "none": kNone. Throws InputError with `name` for an
// unknown compression.
Compression ParseCompression(const std::string& word, const std::string& name);

// Decompresses `bytes` to exactly `size` bytes, at most 256 MiB. LZ4 data must be frames. Memory
// grows with the actual output, so a wrong `size` cannot exhaust it. Throws InputError with `name`
// if `size` is larger, and if the data is damaged or has another size. Bytes after the end of a
// compressed stream are ignored.
std::string Decompress(Compression compression, const std::string& bytes, std::uint64_t size,
                       const std::string& name);

// As Decompress(), for a zstd frame that stores its content size. Throws InputError without this
// size.
std::string DecompressZstd(const std::string& bytes, const std::string& name);

}  // namespace surfit
