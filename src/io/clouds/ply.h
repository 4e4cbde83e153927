#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "surfit/io/point_cloud.h"

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

// Returns the column of a scalar property, or nothing if there is no such property.
std::optional<std::size_t> FindPlyColumn(const PlyElement& element, std::string_view name);

// Where three scalar properties stand in a row, if all of them do.
using PlyNames = std::array<const char*, 3>;
using PlyColumns = std::array<std::size_t, 3>;
std::optional<PlyColumns> FindPlyColumns(const PlyElement& element, const PlyNames& names);
// The numbers in these columns of a row.
inline Eigen::Vector3f VectorAt(const double* row, const PlyColumns& c) {
  return Eigen::Vector3d(row[c[0]], row[c[1]], row[c[2]]).cast<float>();
}

// The text of a binary little endian header.
std::string FormatPlyHeader(const std::vector<PlyElement>& elements);

// Calls `row` with the values of each row of the first element of that name, one for each property
// (0 for a list), in the file's order. `begin` is called before the first row, once the file is
// known to be long enough for all of them.
// Throws InputError naming `path`, the element and the row if the body breaks its header's promise.
void ReadPlyElement(std::string_view file, const PlyHeader& header, const std::string& name,
                    const std::string& path, const std::function<void()>& begin,
                    const std::function<void(const double*)>& row);

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

// The cloud in the bytes of a PCD file: x y z of any type, normal_x normal_y normal_z where there
// are all three, rgb or rgba of four bytes. VIEWPOINT is not applied.
// Throws InputError naming `path` and what is wrong with it.
PointCloud ParsePcd(std::string_view file, const std::string& path);

}  // namespace surfit
