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

// PLY files (G. Turk, 1994). The header lists elements. An element is a table with named
// properties.

enum class PlyType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64,
  kInt64,
  kUint64
};

// Bytes of one binary value.
std::size_t PlySize(PlyType type);
// "uchar", "float", ...
std::string_view PlyName(PlyType type);

// Column of an element: a scalar, or a list of varying length.
struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type = {};  // type of the length of a list; empty for a scalar
};

// Table of `count` rows.
struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;
};

// Header of a PLY file.
struct PlyHeader {
  bool ascii = false;  // false: binary
  std::vector<PlyElement> elements;
  std::size_t size = 0;  // bytes of the header, including the line end_header
  int line_count = 0;
  bool big_endian = false;  // byte order of a binary file; false: little endian
};

// Throws InputError with `path`, reason and, for an invalid line, its number. `file`: whole file;
// only the header is read.
PlyHeader ParsePlyHeader(std::string_view file, const std::string& path);

// Compares names of elements or properties without regard to upper and lower case.
bool IsSamePlyName(std::string_view a, std::string_view b);

// First element with this name in upper or lower case, valid as long as `header`. Throws InputError
// with `path` and `name` if there is none.
const PlyElement& FindPlyElement(const PlyHeader& header, std::string_view name,
                                 const std::string& path);

// Column of the scalar property with this name, otherwise with this name in upper or mixed case.
// std::nullopt if there is no such property.
std::optional<std::size_t> FindPlyColumn(const PlyElement& element, std::string_view name);

using PlyNames = std::array<const char*, 3>;
using PlyColumns = std::array<std::size_t, 3>;
// Columns of three scalar properties; std::nullopt if one is missing.
std::optional<PlyColumns> FindPlyColumns(const PlyElement& element, const PlyNames& names);
// `row`: row of ReadPlyElement().
inline Eigen::Vector3f VectorAt(const double* row, const PlyColumns& c) {
  return Eigen::Vector3d(row[c[0]], row[c[1]], row[c[2]]).cast<float>();
}

// Converts coordinates to single precision, relative to an origin that the first finite point sets,
// see ReadPointCloud().
class PointReader {
 public:
  // `origin` must outlive the object. Null: coordinates as in the file.
  PointReader(std::optional<Eigen::Vector3d>* origin, const PlyColumns& columns)
      : origin_(origin), columns_(columns) {}
  Eigen::Vector3f operator()(const double* row);

 private:
  std::optional<Eigen::Vector3d>* origin_;
  PlyColumns columns_;
};

// Header of a binary little-endian file, with all elements in this order.
std::string FormatPlyHeader(const std::vector<PlyElement>& elements);

// Calls `row` for each row of the first element `name`. The argument has one value per property in
// file order; the value of a list is 0. `begin` is called before the first row, after the file size
// has been checked. Throws InputError with `path`, element and row if the body is truncated or
// invalid. Without such an element, calls nothing. The argument of `row` is valid during the call.
void ReadPlyElement(std::string_view file, const PlyHeader& header, const std::string& name,
                    const std::string& path, const std::function<void()>& begin,
                    const std::function<void(const double*)>& row);

// Reads a list of each row of the first element with this name. The list is the first one with a
// name in `properties`, in upper or lower case. Calls `list` with its values. Calls nothing without
// such an element or list. Throws like ReadPlyElement(). The argument of `list` is valid during the
// call.
void ReadPlyLists(std::string_view file, const PlyHeader& header, const std::string& name,
                  const std::vector<std::string>& properties, const std::string& path,
                  const std::function<void(const std::vector<double>&)>& list);

// Row of a binary little-endian table, filled value by value.
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

// Writes a PLY file with the single element `vertex` atomically. `fill(i, row)` must put the values
// of row i in the order and types of `properties`, which must be scalars (checked in debug builds
// only). Throws InputError with the path if writing fails.
void WritePlyVertices(const std::string& path, std::size_t count,
                      const std::vector<PlyProperty>& properties,
                      const std::function<void(std::size_t, PlyRow*)>& fill);

// Reads x y z of any type, normal_x normal_y normal_z if all exist, and rgb or rgba of four bytes.
// VIEWPOINT is not applied. `origin`: as in PointReader. Throws InputError with `path` and reason.
PointCloud ParsePcd(std::string_view file, const std::string& path,
                    std::optional<Eigen::Vector3d>* origin);

}  // namespace surfit
