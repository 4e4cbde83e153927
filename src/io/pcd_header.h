#pragma once

#include <string>
#include <string_view>

#include "io/ply_header.h"

namespace surfit {

// The header of a PCD file (Point Cloud Data, version 0.7).
struct PcdHeader {
  enum class Data { kAscii, kBinary, kBinaryCompressed };

  // The points as an element of a PLY file, whose rows a PCD file has as well; a field of several
  // values becomes as many properties of its name. `rgb` of four bytes is a uint32 where it is
  // binary, even if it says float: its bits are the colour.
  PlyElement points;
  Data data = Data::kAscii;
  std::size_t size = 0;  // bytes, the line DATA and its line feed included
};

// Throws InputError naming `path` and what is wrong with it.
PcdHeader ParsePcdHeader(std::string_view file, const std::string& path);

}  // namespace surfit
