#include <algorithm>
#include <array>
#include <cctype>

#include "io/clouds/ply.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

struct TypeNames {
  PlyType type;
  std::size_t size;
  std::string_view name, sized_name;
};

constexpr std::array<TypeNames, 10> kTypes = {{{PlyType::kInt8, 1, "char", "int8"},
                                               {PlyType::kUint8, 1, "uchar", "uint8"},
                                               {PlyType::kInt16, 2, "short", "int16"},
                                               {PlyType::kUint16, 2, "ushort", "uint16"},
                                               {PlyType::kInt32, 4, "int", "int32"},
                                               {PlyType::kUint32, 4, "uint", "uint32"},
                                               {PlyType::kFloat32, 4, "float", "float32"},
                                               {PlyType::kFloat64, 8, "double", "float64"},
                                               {PlyType::kInt64, 8, "int64", "int64"},
                                               {PlyType::kUint64, 8, "uint64", "uint64"}}};

PlyType ParseType(std::string_view word) {
  for (const TypeNames& t : kTypes) {
    if (word == t.name || word == t.sized_name) return t.type;
  }
  throw InputError("unknown type '", word, "'");
}

void ParseFormat(const Words& words, PlyHeader* header) {
  const bool has_version = words.size() == 3 && words[2] == "1.0";
  header->ascii = has_version && words[1] == "ascii";
  header->big_endian = has_version && words[1] == "binary_big_endian";
  if (header->ascii || header->big_endian) return;
  ThrowIf(!has_version || words[1] != "binary_little_endian",
          "the format must be 'ascii 1.0', 'binary_little_endian 1.0' or 'binary_big_endian 1.0'");
}

bool IsSameLetter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

PlyProperty ParseProperty(const Words& words) {
  PlyProperty property;
  property.name = words.back();
  if (words.size() == 3) {
    property.type = ParseType(words[1]);
  } else if (words.size() == 5 && words[1] == "list") {
    property.count_type = ParseType(words[2]);
    property.type = ParseType(words[3]);
  } else {
    throw InputError("a property must be 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  return property;
}

// Parses one line between `format` and `end_header`.
void ParseLine(const Words& words, PlyHeader* header) {
  if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return;
  if (words[0] == "element" && words.size() == 3) {
    header->elements.push_back({std::string(words[1]), ParseCount(words[2]), {}});
  } else if (words[0] == "property" && !header->elements.empty()) {
    header->elements.back().properties.push_back(ParseProperty(words));
  } else {
    throw InputError("'", words[0], "' is misplaced or incomplete");
  }
}

}  // namespace

bool IsSamePlyName(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), IsSameLetter);
}

std::size_t PlySize(PlyType type) { return kTypes[static_cast<std::size_t>(type)].size; }

std::string_view PlyName(PlyType type) { return kTypes[static_cast<std::size_t>(type)].name; }

PlyHeader ParsePlyHeader(std::string_view file, const std::string& path) {
  PlyHeader header;
  bool has_format = false;
  while (true) {
    const std::size_t line_size = file.substr(header.size).find('\n');
    ThrowIf(header.line_count == 0 && SplitWords(file.substr(0, line_size)) != Words{"ply"}, path,
            ": not a PLY file, the first line must be 'ply'");
    ThrowIf(line_size == file.npos, path, ": the header has no end_header");
    const Words words = SplitWords(file.substr(header.size, line_size));
    header.size += line_size + 1;
    ++header.line_count;
    try {
      if (header.line_count == 1) continue;
      if (!words.empty() && words[0] == "end_header") break;
      if (!words.empty() && words[0] == "format") {
        ParseFormat(words, &header);
        has_format = true;
      } else {
        ParseLine(words, &header);
      }
    } catch (const InputError& error) {
      throw InputError(path, ":", header.line_count, ": ", error.what());
    }
  }
  ThrowIf(!has_format, path, ": the header has no format");
  return header;
}

const PlyElement& FindPlyElement(const PlyHeader& header, std::string_view name,
                                 const std::string& path) {
  for (const PlyElement& element : header.elements) {
    if (IsSamePlyName(element.name, name)) return element;
  }
  throw InputError(path, ": the header has no element '", name, "'");
}

std::optional<std::size_t> FindPlyColumn(const PlyElement& element, std::string_view name) {
  const auto& properties = element.properties;
  auto at = std::find_if(properties.begin(), properties.end(),
                         [&](const PlyProperty& p) { return p.name == name && !p.count_type; });
  if (at == properties.end()) {
    at = std::find_if(properties.begin(), properties.end(), [&](const PlyProperty& p) {
      return IsSamePlyName(p.name, name) && !p.count_type;
    });
  }
  if (at == properties.end()) return std::nullopt;
  return at - properties.begin();
}

std::optional<PlyColumns> FindPlyColumns(const PlyElement& element, const PlyNames& names) {
  PlyColumns columns;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto column = FindPlyColumn(element, names[k]);
    if (!column) return std::nullopt;
    columns[k] = *column;
  }
  return columns;
}

std::string FormatPlyHeader(const std::vector<PlyElement>& elements) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const PlyElement& element : elements) {
    text += Concat("element ", element.name, " ", element.count, "\n");
    for (const PlyProperty& property : element.properties) {
      text += "property ";
      if (property.count_type) text += Concat("list ", PlyName(*property.count_type), " ");
      text += Concat(PlyName(property.type), " ", property.name, "\n");
    }
  }
  return text + "end_header\n";
}

}  // namespace surfit
