#pragma once

#include <cstddef>
#include <string>

namespace surfit {

// Data in zlib's format (RFC 1950), by libdeflate. Both throw std::bad_alloc.

// False unless the data expand to just so many bytes, with the checksum that they end with.
bool Inflate(const void* data, std::size_t size, void* bytes, std::size_t count);

// level from 1 (quick) to 9 (small).
std::string Deflate(const void* bytes, std::size_t count, int level);

}  // namespace surfit
