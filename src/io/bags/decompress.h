#pragma once

#include <cstdint>
#include <string>

namespace surfit {

enum class Compression { kNone, kLz4, kZstd, kBz2 };

// The compression of that name, as bags have it; "" and "none" are kNone. Throws InputError naming
// `name` and the known ones for any other.
Compression CompressionOf(const std::string& word, const std::string& name);

// What the bytes were before they were compressed (LZ4 as frames), `size` bytes. Memory grows with
// what comes out, whatever `size` claims, and to 256 megabytes at most. Throws InputError naming
// `name` if the bytes are damaged, or more or fewer come out.
std::string Decompress(Compression compression, const std::string& bytes, std::uint64_t size,
                       const std::string& name);

// The same of one frame of zstd that tells its size itself.
std::string DecompressZstd(const std::string& bytes, const std::string& name);

}  // namespace surfit
