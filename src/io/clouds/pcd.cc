#include <lzf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <optional>

#include "io/clouds/ply.h"
#include "io/files/text.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

// The header of a PCD file (Point Cloud Data, version 0.7).
struct PcdHeader {
  enum class Data { kAscii, kBinary, kBinaryCompressed };

  // Fields as a PLY element: both formats store the same rows. A field of several values becomes
  // several properties with the same name. Binary `rgb` of four bytes is a uint32, even if its TYPE
  // is F, because its bits are the colour.
  PlyElement points;
  Data data = Data::kAscii;
  std::size_t size = 0;  // bytes of the header, including the line DATA
};

constexpr std::int64_t kMaxValuesInField = 1 << 16;

// Header lines: the first word is the key, the other words are the value.
using Entries = std::map<std::string_view, Words, std::less<>>;

const Words& Find(const Entries& entries, std::string_view key, std::size_t count) {
  const auto entry = entries.find(key);
  ThrowIf(entry == entries.end(), "the header has no ", key);
  ThrowIf(entry->second.size() != count, key, " has ", entry->second.size(), " values, must have ",
          count);
  return entry->second;
}

PlyType ParseType(std::string_view type, std::string_view size) {
  const std::string name = Concat(type, size);
  const std::map<std::string, PlyType> types = {
      {"I1", PlyType::kInt8},    {"I2", PlyType::kInt16},   {"I4", PlyType::kInt32},
      {"U1", PlyType::kUint8},   {"U2", PlyType::kUint16},  {"U4", PlyType::kUint32},
      {"F4", PlyType::kFloat32}, {"F8", PlyType::kFloat64}, {"I8", PlyType::kInt64},
      {"U8", PlyType::kUint64}};
  const auto known = types.find(name);
  ThrowIf(known == types.end(), "a field has type ", type, " and size ", size,
          ", must be I or U of 1, 2, 4 or 8 bytes or F of 4 or 8");
  return known->second;
}

PcdHeader::Data ParseData(const Words& words) {
  if (words[0] == "ascii") return PcdHeader::Data::kAscii;
  if (words[0] == "binary") return PcdHeader::Data::kBinary;
  if (words[0] == "binary_compressed") return PcdHeader::Data::kBinaryCompressed;
  throw InputError("DATA is '", words[0], "', must be ascii, binary or binary_compressed");
}

std::vector<PlyProperty> ParseFields(const Entries& entries, PcdHeader::Data data) {
  const auto fields = entries.find("FIELDS");
  ThrowIf(fields == entries.end(), "the header has no FIELDS");
  const Words& names = fields->second;
  const Words& sizes = Find(entries, "SIZE", names.size());
  const Words& types = Find(entries, "TYPE", names.size());
  const bool has_counts = entries.count("COUNT") > 0;
  std::vector<PlyProperty> properties;
  for (std::size_t k = 0; k < names.size(); ++k) {
    PlyProperty property{std::string(names[k]), ParseType(types[k], sizes[k])};
    const bool is_color = property.name == "rgb" || property.name == "rgba";
    if (is_color && PlySize(property.type) == 4 && data != PcdHeader::Data::kAscii) {
      property.type = PlyType::kUint32;
    }
    const std::int64_t count = has_counts ? ParseCount(Find(entries, "COUNT", names.size())[k]) : 1;
    ThrowIf(count > kMaxValuesInField, "COUNT of a field is ", count, ", must be at most ",
            kMaxValuesInField);
    properties.insert(properties.end(), count, property);
  }
  return properties;
}

std::int64_t ParsePointCount(const Entries& entries) {
  const std::int64_t width = ParseCount(Find(entries, "WIDTH", 1)[0]);
  const std::int64_t height = ParseCount(Find(entries, "HEIGHT", 1)[0]);
  ThrowIf(height > 0 && width > std::numeric_limits<std::int64_t>::max() / height,
          "WIDTH x HEIGHT is ", width, " x ", height, ", must be below 2^63");
  if (entries.count("POINTS") == 0) return width * height;
  const std::int64_t points = ParseCount(Find(entries, "POINTS", 1)[0]);
  ThrowIf(points != width * height, "POINTS is ", points,
          ", must be WIDTH x HEIGHT = ", width * height);
  return points;
}

constexpr std::string_view kKeys[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                      "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

// Parses the header lines up to DATA. *size: number of bytes read.
Entries ParseLines(std::string_view file, std::size_t* size) {
  Entries entries;
  while (entries.count("DATA") == 0) {
    const std::size_t line_size = file.substr(*size).find('\n');
    ThrowIf(line_size == file.npos, "neither PLY nor PCD: the header has no line DATA");
    const Words words = SplitWords(file.substr(*size, line_size));
    *size += line_size + 1;
    if (words.empty() || words[0][0] == '#') continue;
    ThrowIf(
        std::find(std::begin(kKeys), std::end(kKeys), words[0]) == std::end(kKeys),
        "neither a PLY file, which begins with 'ply', nor a PCD file, which begins with VERSION");
    entries[words[0]].assign(words.begin() + 1, words.end());
  }
  return entries;
}

// Throws InputError with `path` and reason.
PcdHeader ParsePcdHeader(std::string_view file, const std::string& path) {
  return WithContext(path, [&] {
    PcdHeader header;
    const Entries entries = ParseLines(file, &header.size);
    header.data = ParseData(Find(entries, "DATA", 1));
    header.points = {"points", ParsePointCount(entries), ParseFields(entries, header.data)};
    return header;
  });
}

std::size_t NextUint32(std::string_view* bytes) {
  std::uint32_t value = 0;
  if (bytes->size() < sizeof(value)) throw InputError("the file ends before its points");
  std::memcpy(&value, bytes->data(), sizeof(value));
  bytes->remove_prefix(sizeof(value));
  return value;
}

// Decompresses LZF data (M. Lehmann) to exactly `size` bytes. Throws InputError if the size
// differs.
std::string ExpandLzf(std::string_view compressed, std::size_t size) {
  constexpr std::size_t kMaxExpansion = 88;  // the longest match is 264 bytes, stored in 3 bytes
  std::string bytes;
  std::size_t expanded = 0;
  if (!compressed.empty() && size / kMaxExpansion <= compressed.size()) {
    bytes.resize(size);
    expanded = lzf_decompress(compressed.data(), static_cast<unsigned>(compressed.size()),
                              bytes.data(), static_cast<unsigned>(size));
  }
  ThrowIf(expanded != size, "the compressed data is damaged, it must expand to ", size, " bytes");
  return bytes;
}

// Decompresses the body and converts it to rows. Compressed files store all values of a field
// contiguously.
std::string ExpandToRows(std::string_view body, const PlyElement& points) {
  const std::size_t compressed_size = NextUint32(&body), size = NextUint32(&body);
  std::size_t row_size = 0;
  for (const PlyProperty& property : points.properties) row_size += PlySize(property.type);
  const auto count = static_cast<std::size_t>(points.count);
  ThrowIf(row_size == 0 || count > size / row_size || count * row_size != size, "there are ", size,
          " bytes of points, must be ", count, " x ", row_size);
  ThrowIf(compressed_size > body.size(), "the file ends before its points");
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

// Column of a packed 32-bit colour; std::nullopt if there is none.
std::optional<std::size_t> FindColor(const PlyElement& points) {
  for (std::size_t k = 0; k < points.properties.size(); ++k) {
    const PlyProperty& property = points.properties[k];
    const bool is_color = property.name == "rgb" || property.name == "rgba";
    if (is_color && PlySize(property.type) == 4) return k;
  }
  return std::nullopt;
}

// Unpacks the colour 0xaarrggbb. Ascii files can store these bits as a float.
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

bool IsFar(const PointCloud& cloud) { return !cloud.origin.isZero(0); }

std::string FormatHeader(const PointCloud& cloud) {
  std::string names = "x y z";
  int count = 0;  // of columns after x y z
  if (!cloud.normals.empty()) {
    names += " normal_x normal_y normal_z";
    count += 3;
  }
  if (!cloud.colors.empty()) {
    names += " rgb";
    ++count;
  }
  const auto repeated = [count](const char* word) {
    std::string line;
    for (int i = 0; i < count; ++i) line += word;
    return line;
  };
  return Concat("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS ", names, "\nSIZE",
                IsFar(cloud) ? " 8 8 8" : " 4 4 4", repeated(" 4"), "\nTYPE F F F", repeated(" F"),
                "\nCOUNT 1 1 1", repeated(" 1"), "\nWIDTH ", cloud.points.size(),
                "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", cloud.points.size(),
                "\nDATA binary\n");
}

}  // namespace

PointCloud ParsePcd(std::string_view file, const std::string& path,
                    std::optional<Eigen::Vector3d>* origin) {
  const PcdHeader header = ParsePcdHeader(file, path);
  const auto points = FindPlyColumns(header.points, {"x", "y", "z"});
  if (!points) throw InputError(path, ": FIELDS must have x, y and z");
  const auto normals = FindPlyColumns(header.points, {"normal_x", "normal_y", "normal_z"});
  const auto color = FindColor(header.points);

  PlyHeader table{header.data == PcdHeader::Data::kAscii, {header.points}, header.size};
  std::string rows;
  if (header.data == PcdHeader::Data::kBinaryCompressed) {
    rows = WithContext(path, [&] { return ExpandToRows(file.substr(header.size), header.points); });
    file = rows;
    table.size = 0;
  }
  PointCloud cloud;
  PointReader read_point(origin, *points);
  const auto begin = [&] {
    cloud.points.reserve(header.points.count);
    if (normals) cloud.normals.reserve(header.points.count);
    if (color) cloud.colors.reserve(header.points.count);
  };
  ReadPlyElement(file, table, header.points.name, path, begin, [&](const double* row) {
    cloud.points.push_back(read_point(row));
    if (normals) cloud.normals.push_back(VectorAt(row, *normals));
    if (color) {
      cloud.colors.push_back(UnpackColor(row[*color], header.points.properties[*color].type));
    }
  });
  return cloud;
}

void WritePcd(const PointCloud& cloud, const std::string& path) {
  const auto require = [&](const char* name, std::size_t size) {
    ThrowIf(size != 0 && size != cloud.points.size(), path, ": the cloud has ", cloud.points.size(),
            " points and ", size, " ", name, ", must have one per point or none");
  };
  require("normals", cloud.normals.size());
  require("colors", cloud.colors.size());
  require("radii_m", cloud.radii_m.size());
  require("confidences", cloud.confidences.size());
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << FormatHeader(cloud);
    PlyRow row;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      row.Clear();
      if (IsFar(cloud)) {
        const Eigen::Vector3d point = cloud.origin + cloud.points[i].cast<double>();
        for (const double value : point) row.Put(value);
      } else {
        for (const float value : cloud.points[i]) row.Put(value);
      }
      if (!cloud.normals.empty()) {
        for (const float value : cloud.normals[i]) row.Put(value);
      }
      if (!cloud.colors.empty()) {
        const Rgb8 c = cloud.colors[i];
        row.Put(std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | std::uint32_t{c.b});
      }
      out.write(row.bytes().data(), static_cast<std::streamsize>(row.bytes().size()));
    }
  });
}

}  // namespace surfit
