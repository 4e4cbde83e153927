#pragma once

#include <cstdint>
#include <fstream>
#include <string>

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

}  // namespace surfit
