#include "io/pcd_header.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

#include "io/words.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::int64_t kMostValuesInField = 1 << 16;

// The words after the first of each line, by the first.
using Entries = std::map<std::string_view, Words, std::less<>>;

const Words& Find(const Entries& entries, std::string_view key, std::size_t count) {
  const auto entry = entries.find(key);
  if (entry == entries.end()) throw InputError(Concat("the header has no ", key));
  if (entry->second.size() != count) {
    throw InputError(Concat(key, " has ", entry->second.size(), " values, must have ", count));
  }
  return entry->second;
}

PlyType ParseType(std::string_view type, std::string_view size) {
  const std::string name = Concat(type, size);
  const std::map<std::string, PlyType> types = {
      {"I1", PlyType::kInt8},    {"I2", PlyType::kInt16},  {"I4", PlyType::kInt32},
      {"U1", PlyType::kUint8},   {"U2", PlyType::kUint16}, {"U4", PlyType::kUint32},
      {"F4", PlyType::kFloat32}, {"F8", PlyType::kFloat64}};
  const auto known = types.find(name);
  if (known == types.end()) {
    throw InputError(Concat("a field has type ", type, " and size ", size,
                            ", must be I or U of 1, 2 or 4 bytes or F of 4 or 8"));
  }
  return known->second;
}

PcdHeader::Data ParseData(const Words& words) {
  if (words[0] == "ascii") return PcdHeader::Data::kAscii;
  if (words[0] == "binary") return PcdHeader::Data::kBinary;
  if (words[0] == "binary_compressed") return PcdHeader::Data::kBinaryCompressed;
  throw InputError(Concat("DATA is '", words[0], "', must be ascii, binary or binary_compressed"));
}

std::vector<PlyProperty> ParseFields(const Entries& entries, PcdHeader::Data data) {
  const auto fields = entries.find("FIELDS");
  if (fields == entries.end()) throw InputError("the header has no FIELDS");
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
    if (count > kMostValuesInField) {
      throw InputError(
          Concat("COUNT of a field is ", count, ", must be at most ", kMostValuesInField));
    }
    properties.insert(properties.end(), count, property);
  }
  return properties;
}

std::int64_t ParsePointCount(const Entries& entries) {
  const std::int64_t width = ParseCount(Find(entries, "WIDTH", 1)[0]);
  const std::int64_t height = ParseCount(Find(entries, "HEIGHT", 1)[0]);
  if (height > 0 && width > std::numeric_limits<std::int64_t>::max() / height) {
    throw InputError(Concat("WIDTH x HEIGHT is ", width, " x ", height, ", must be below 2^63"));
  }
  if (entries.count("POINTS") == 0) return width * height;
  const std::int64_t points = ParseCount(Find(entries, "POINTS", 1)[0]);
  if (points != width * height) {
    throw InputError(Concat("POINTS is ", points, ", must be WIDTH x HEIGHT = ", width * height));
  }
  return points;
}

constexpr std::string_view kKeys[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                      "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

// Reads the lines up to DATA, which takes *size bytes.
Entries ParseLines(std::string_view file, std::size_t* size) {
  Entries entries;
  while (entries.count("DATA") == 0) {
    const std::size_t line_size = file.substr(*size).find('\n');
    if (line_size == file.npos)
      throw InputError("neither PLY nor PCD: the header has no line DATA");
    const Words words = SplitWords(file.substr(*size, line_size));
    *size += line_size + 1;
    if (words.empty() || words[0][0] == '#') continue;
    if (std::find(std::begin(kKeys), std::end(kKeys), words[0]) == std::end(kKeys)) {
      throw InputError(
          "neither a PLY file, which begins with 'ply', nor a PCD file, which begins with VERSION");
    }
    entries[words[0]].assign(words.begin() + 1, words.end());
  }
  return entries;
}

}  // namespace

PcdHeader ParsePcdHeader(std::string_view file, const std::string& path) {
  try {
    PcdHeader header;
    const Entries entries = ParseLines(file, &header.size);
    header.data = ParseData(Find(entries, "DATA", 1));
    header.points = {"points", ParsePointCount(entries), ParseFields(entries, header.data)};
    return header;
  } catch (const InputError& error) {
    throw InputError(Concat(path, ": ", error.what()));
  }
}

}  // namespace surfit
