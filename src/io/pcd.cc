#include "io/pcd.h"

#include <lzf.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "io/pcd_header.h"
#include "io/ply_body.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Takes 32 bits from the front.
std::size_t NextUint32(std::string_view* bytes) {
  std::uint32_t value = 0;
  if (bytes->size() < sizeof(value)) throw InputError("the file ends before its points");
  std::memcpy(&value, bytes->data(), sizeof(value));
  bytes->remove_prefix(sizeof(value));
  return value;
}

// Expands LZF (M. Lehmann) that holds exactly `size` bytes.
std::string ExpandLzf(std::string_view compressed, std::size_t size) {
  constexpr std::size_t kMostExpansion = 88;  // the longest match, 264 bytes, takes three
  std::string bytes;
  std::size_t expanded = 0;
  if (!compressed.empty() && size / kMostExpansion <= compressed.size()) {
    bytes.resize(size);
    expanded = lzf_decompress(compressed.data(), static_cast<unsigned>(compressed.size()),
                              bytes.data(), static_cast<unsigned>(size));
  }
  if (expanded != size) {
    throw InputError(Concat("the compressed data is damaged, it must expand to ", size, " bytes"));
  }
  return bytes;
}

// Compressed data holds all values of the first field, then all of the next, and so on: the same
// as rows.
std::string ExpandToRows(std::string_view body, const PlyElement& points) {
  const std::size_t compressed_size = NextUint32(&body), size = NextUint32(&body);
  std::size_t row_size = 0;
  for (const PlyProperty& property : points.properties) row_size += PlySize(property.type);
  const auto count = static_cast<std::size_t>(points.count);
  if (row_size == 0 || count > size / row_size || count * row_size != size) {
    throw InputError(
        Concat("there are ", size, " bytes of points, must be ", count, " x ", row_size));
  }
  if (compressed_size > body.size()) throw InputError("the file ends before its points");
  const std::string columns = ExpandLzf(body.substr(0, compressed_size), size);
  std::string rows(size, '\0');
  std::size_t from = 0, column = 0;
  for (const PlyProperty& property : points.properties) {
    const std::size_t width = PlySize(property.type);
    for (std::size_t i = 0; i < count; ++i, from += width) {
      std::copy_n(&columns[from], width, &rows[i * row_size + column]);
    }
    column += width;
  }
  return rows;
}

// The column that holds a colour in its 32 bits, if any.
std::optional<std::size_t> FindColor(const PlyElement& points) {
  for (std::size_t k = 0; k < points.properties.size(); ++k) {
    const PlyProperty& property = points.properties[k];
    const bool is_color = property.name == "rgb" || property.name == "rgba";
    if (is_color && PlySize(property.type) == 4) return k;
  }
  return std::nullopt;
}

// 0xaarrggbb, which ascii files may give as the float of the same bits.
Rgb8 UnpackColor(double value, PlyType type) {
  std::uint32_t bits = 0;
  if (type == PlyType::kFloat32) {
    const auto single = static_cast<float>(value);
    std::memcpy(&bits, &single, sizeof(bits));
  } else if (value >= 0 && value <= 0xffffffff) {
    bits = static_cast<std::uint32_t>(value);
  }
  return {static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 8),
          static_cast<std::uint8_t>(bits)};
}

Eigen::Vector3f Vector(const double* row, const PlyColumns& c) {
  return Eigen::Vector3d(row[c[0]], row[c[1]], row[c[2]]).cast<float>();
}

}  // namespace

PointCloud ParsePcd(std::string_view file, const std::string& path) {
  const PcdHeader header = ParsePcdHeader(file, path);
  const auto points = FindPlyColumns(header.points, {"x", "y", "z"});
  if (!points) throw InputError(Concat(path, ": FIELDS must have x, y and z"));
  const auto normals = FindPlyColumns(header.points, {"normal_x", "normal_y", "normal_z"});
  const auto color = FindColor(header.points);

  PlyHeader table{header.data == PcdHeader::Data::kAscii, {header.points}, header.size};
  std::string rows;
  if (header.data == PcdHeader::Data::kBinaryCompressed) {
    try {
      rows = ExpandToRows(file.substr(header.size), header.points);
    } catch (const InputError& error) {
      throw InputError(Concat(path, ": ", error.what()));
    }
    file = rows;
    table.size = 0;
  }
  PointCloud cloud;
  const auto begin = [&] {
    cloud.points.reserve(header.points.count);
    if (normals) cloud.normals.reserve(header.points.count);
    if (color) cloud.colors.reserve(header.points.count);
  };
  ReadPlyElement(file, table, header.points.name, path, begin, [&](const double* row) {
    cloud.points.push_back(Vector(row, *points));
    if (normals) cloud.normals.push_back(Vector(row, *normals));
    if (color) {
      cloud.colors.push_back(UnpackColor(row[*color], header.points.properties[*color].type));
    }
  });
  return cloud;
}

}  // namespace surfit
