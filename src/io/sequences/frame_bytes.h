#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "io/images/image_files.h"
#include "surfit/core/image.h"

namespace surfit {

// A file of binary little endian values that is too large to be read at once. Whether bytes are
// there is checked before memory is taken for them.
class BinaryFile {
 public:
  // Throws InputError naming the file if it cannot be opened.
  explicit BinaryFile(const std::string& path);

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  bool Has(std::uint64_t at, std::uint64_t count) const {
    return at <= size_ && count <= size_ - at;
  }
  // Throws InputError naming the file if it ends before, or cannot be read.
  std::string Read(std::uint64_t at, std::uint64_t count) const;

 private:
  std::string path_;
  mutable std::ifstream file_;
  std::uint64_t size_ = 0;
};

// Takes values one after the other from bytes in memory, which must hold them.
class ByteReader {
 public:
  explicit ByteReader(const std::string& bytes) : bytes_(bytes) {}
  template <typename T>
  T Take() {
    T value{};
    bytes_.copy(reinterpret_cast<char*>(&value), sizeof(T), at_);
    at_ += sizeof(T);
    return value;
  }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

// The images within .klg and .sens files. All throw InputError naming `name` unless the bytes hold
// an image of that size; it is compared with what they can hold before memory is taken for it.

// 16-bit little endian counts, row by row.
Image<std::uint16_t> CopyDepth(const std::string& bytes, ImageSize size, const std::string& name);
// The same compressed by zlib.
Image<std::uint16_t> InflateDepth(const std::string& bytes, ImageSize size,
                                  const std::string& name);

// Red, green, blue, row by row.
Image<Rgb8> CopyColor(const std::string& bytes, ImageSize size, const std::string& name);
// JPEG or PNG.
Image<Rgb8> DecodeColor(const std::string& bytes, ImageSize size, const std::string& name);

}  // namespace surfit
