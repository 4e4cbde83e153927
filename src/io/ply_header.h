#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace surfit {

// The header of a PLY file (G. Turk, 1994): elements, each a table of rows with named properties.

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

// Bytes of one binary value.
std::size_t PlySize(PlyType type);
// "uchar", "float", ...
std::string_view PlyName(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type = {};  // of a list: the type of the count before its values
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  bool ascii = false;  // else binary little endian
  std::vector<PlyElement> elements;
  std::size_t size = 0;  // bytes, end_header and its line feed included
  int line_count = 0;
};

// Throws InputError naming `path`, the line and what is wrong with it.
PlyHeader ParsePlyHeader(std::string_view file, const std::string& path);

// Throws InputError naming `path` and the element if there is none of that name.
const PlyElement& FindPlyElement(const PlyHeader& header, std::string_view name,
                                 const std::string& path);

// Where three scalar properties stand in a row, if all of them do.
using PlyNames = std::array<const char*, 3>;
using PlyColumns = std::array<std::size_t, 3>;
std::optional<PlyColumns> FindPlyColumns(const PlyElement& element, const PlyNames& names);

// The text of a binary little endian header.
std::string FormatPlyHeader(const std::vector<PlyElement>& elements);

}  // namespace surfit
