#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/clouds/ply.h"
#include "io/files/text.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

template <typename T>
double LoadAs(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double Load(PlyType type, const char* bytes) {
  switch (type) {
    case PlyType::kInt8:
      return LoadAs<std::int8_t>(bytes);
    case PlyType::kUint8:
      return LoadAs<std::uint8_t>(bytes);
    case PlyType::kInt16:
      return LoadAs<std::int16_t>(bytes);
    case PlyType::kUint16:
      return LoadAs<std::uint16_t>(bytes);
    case PlyType::kInt32:
      return LoadAs<std::int32_t>(bytes);
    case PlyType::kUint32:
      return LoadAs<std::uint32_t>(bytes);
    case PlyType::kFloat32:
      return LoadAs<float>(bytes);
    case PlyType::kFloat64:
      return LoadAs<double>(bytes);
    case PlyType::kInt64:
      return LoadAs<std::int64_t>(bytes);
    case PlyType::kUint64:
      return LoadAs<std::uint64_t>(bytes);
  }
  return 0;
}

class BinaryCursor {
 public:
  BinaryCursor(std::string_view body, bool is_big_endian)
      : rest_(body), is_big_endian_(is_big_endian) {}

  std::size_t BytesLeft() const { return rest_.size(); }
  // Minimum size of a value in bytes. An empty list consists of its length only.
  static std::size_t LeastSize(const PlyProperty& p) {
    return PlySize(p.count_type ? *p.count_type : p.type);
  }
  double Next(PlyType type) {
    const std::size_t size = PlySize(type);
    if (rest_.size() < size) throw InputError("the file ends too early");
    std::array<char, 8> bytes;
    std::copy_n(rest_.data(), size, bytes.data());
    if (is_big_endian_) std::reverse(bytes.begin(), bytes.begin() + size);
    rest_.remove_prefix(size);
    return Load(type, bytes.data());
  }
  void Skip(PlyType type, std::uint64_t count) {
    if (rest_.size() / PlySize(type) < count) throw InputError("the file ends too early");
    rest_.remove_prefix(count * PlySize(type));
  }
  void EndRow() {}

 private:
  std::string_view rest_;
  bool is_big_endian_;
};

// Reads the values of an ascii body, one row per line.
class AsciiCursor {
 public:
  explicit AsciiCursor(std::string_view body) : rest_(body) {}

  // Number of unread bytes plus 1, because the last line may have no line feed.
  std::size_t BytesLeft() const { return rest_.size() + 1; }
  // Minimum size of a value in bytes: a digit and a separator.
  static std::size_t LeastSize(const PlyProperty&) { return 2; }
  double Next(PlyType) {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    double value = 0;
    rest_ = WithoutPlus(rest_);
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    rest_.remove_prefix(end - rest_.data());
    const bool ends = rest_.empty() || std::isspace(static_cast<unsigned char>(rest_.front()));
    if (error != std::errc() || !ends) throw InputError("a number is missing or broken");
    return value;
  }
  void Skip(PlyType type, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) Next(type);
  }
  void EndRow() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    if (rest_.empty()) return;
    if (rest_.front() != '\n') throw InputError("there are more values than properties");
    rest_.remove_prefix(1);
  }

 private:
  std::string_view rest_;
};

template <typename Cursor>
void CheckSize(const Cursor& cursor, const PlyElement& element) {
  std::size_t row_size = 0;
  for (const PlyProperty& property : element.properties) row_size += Cursor::LeastSize(property);
  ThrowIf(row_size > 0 && cursor.BytesLeft() / row_size < static_cast<std::size_t>(element.count),
          "the file is too short for ", element.count, " rows");
}

// Returns 0 for a list. Stores its values in `list`, unless that is null.
template <typename Cursor>
double ReadValue(const PlyProperty& property, Cursor* cursor, std::vector<double>* list) {
  if (!property.count_type) return cursor->Next(property.type);
  const double count = cursor->Next(*property.count_type);
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  ThrowIf(!(count >= 0 && count <= kMost && count == std::floor(count)), "the length of list '",
          property.name, "' is ", count);
  const auto values = static_cast<std::uint64_t>(count);
  if (list == nullptr) {
    cursor->Skip(property.type, values);
    return 0;
  }
  list->clear();
  for (std::uint64_t i = 0; i < values; ++i) list->push_back(cursor->Next(property.type));
  return 0;
}

// Use of the rows of one element.
struct RowUse {
  std::string name;  // of the element
  std::function<void()> begin = [] {};
  std::function<void(const double*)> row;
  std::size_t list_column = std::numeric_limits<std::size_t>::max();  // list to read; none
  std::vector<double> list = {};                                      // its values in a row
};

template <typename Cursor>
void ReadRows(const PlyElement& element, RowUse* use, Cursor* cursor) {
  if (element.properties.empty()) return;
  std::vector<double> values(element.properties.size());
  for (std::int64_t i = 0; i < element.count; ++i) {
    try {
      for (std::size_t k = 0; k < values.size(); ++k) {
        const bool is_read = use != nullptr && k == use->list_column;
        values[k] = ReadValue(element.properties[k], cursor, is_read ? &use->list : nullptr);
      }
      cursor->EndRow();
    } catch (const InputError& error) {
      throw InputError("row ", i, ": ", error.what());
    }
    if (use != nullptr) use->row(values.data());
  }
}

template <typename Cursor>
void ReadElement(Cursor cursor, const PlyHeader& header, const std::string& path, RowUse* use) {
  for (const PlyElement& element : header.elements) {
    const bool wanted = element.name == use->name;
    try {
      CheckSize(cursor, element);
      if (wanted) use->begin();
      ReadRows(element, wanted ? use : nullptr, &cursor);
    } catch (const InputError& error) {
      throw InputError(path, ": element '", element.name, "': ", error.what());
    }
    if (wanted) return;
  }
}

void ReadElement(std::string_view file, const PlyHeader& header, const std::string& path,
                 RowUse* use) {
  const std::string_view body = file.substr(header.size);
  if (header.ascii) {
    ReadElement(AsciiCursor(body), header, path, use);
  } else {
    ReadElement(BinaryCursor(body, header.big_endian), header, path, use);
  }
}

}  // namespace

void ReadPlyElement(std::string_view file, const PlyHeader& header, const std::string& name,
                    const std::string& path, const std::function<void()>& begin,
                    const std::function<void(const double*)>& row) {
  RowUse use = {name, begin, row};
  ReadElement(file, header, path, &use);
}

void ReadPlyLists(std::string_view file, const PlyHeader& header, const std::string& name,
                  const std::vector<std::string>& properties, const std::string& path,
                  const std::function<void(const std::vector<double>&)>& list) {
  const auto element =
      std::find_if(header.elements.begin(), header.elements.end(),
                   [&](const PlyElement& e) { return IsSamePlyName(e.name, name); });
  if (element == header.elements.end()) return;
  const std::vector<PlyProperty>& columns = element->properties;
  const auto column = std::find_if(columns.begin(), columns.end(), [&](const PlyProperty& p) {
    const auto is_name = [&](const std::string& other) { return IsSamePlyName(p.name, other); };
    return p.count_type && std::any_of(properties.begin(), properties.end(), is_name);
  });
  if (column == columns.end()) return;
  RowUse use = {element->name, [] {}, {}, static_cast<std::size_t>(column - columns.begin())};
  use.row = [&](const double*) { list(use.list); };
  ReadElement(file, header, path, &use);
}

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "PLY bodies are copied from memory");

void WritePlyVertices(const std::string& path, std::size_t count,
                      const std::vector<PlyProperty>& properties,
                      const std::function<void(std::size_t, PlyRow*)>& fill) {
  std::size_t row_size = 0;
  for (const PlyProperty& property : properties) row_size += PlySize(property.type);
  const PlyElement vertex{"vertex", static_cast<std::int64_t>(count), properties};
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << FormatPlyHeader({vertex});
    PlyRow row;
    for (std::size_t i = 0; i < count; ++i) {
      row.Clear();
      fill(i, &row);
      DCHECK_EQ(row.bytes().size(), row_size);
      out.write(row.bytes().data(), row.bytes().size());
    }
  });
}

}  // namespace surfit
