#pragma once

#include <cstddef>
#include <string>

namespace surfit {

// Compression in the zlib format (RFC 1950) with libdeflate. Both functions are
// thread-safe, and throw std::bad_alloc without memory.

// Returns false unless the data decompress to exactly `count` bytes with a correct checksum.
// `bytes` must have space for `count` bytes. Its content is unspecified after a failure.
bool Inflate(const void* data, std::size_t size, void* bytes, std::size_t count);

// `level`: 1 (fast) to 9 (small), not checked.
std::string Deflate(const void* bytes, std::size_t count, int level);

}  // namespace surfit
