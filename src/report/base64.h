#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace surfit {

// Base64 with padding (RFC 4648, section 4).
std::string EncodeBase64(const unsigned char* bytes, std::size_t count);
inline std::string EncodeBase64(const std::string& bytes) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

// The bytes of the values as they lie in memory: little endian on all processors that we know, and
// in every browser.
template <typename T>
std::string EncodeBase64(const std::vector<T>& values) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(values.data()),
                      values.size() * sizeof(T));
}

}  // namespace surfit
