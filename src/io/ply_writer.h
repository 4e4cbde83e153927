#pragma once

#include <cstring>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "io/ply_header.h"

namespace surfit {

// One row of a binary little endian table, filled value by value.
class PlyRow {
 public:
  template <typename T>
  void Put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(&bytes_[at], &value, sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }
  void Clear() { bytes_.clear(); }

 private:
  std::string bytes_;
};

// Writes a PLY file whose only element is `vertex`, atomically; `fill(i, row)` puts the values of
// row i in the properties' order and types.
void WritePlyVertices(const std::string& path, std::size_t count,
                      const std::vector<PlyProperty>& properties,
                      const std::function<void(std::size_t, PlyRow*)>& fill);

}  // namespace surfit
